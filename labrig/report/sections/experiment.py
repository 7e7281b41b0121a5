"""The experiment: the sheets (table 3), the signals (figures 5, 6) and the curves (figure 7)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from labrig.errors import BadInputError
from labrig.report.data.findings import Findings
from labrig.report.figures.frame import frame_figure
from labrig.report.figures.shapes import curves_figure
from labrig.report.figures.signals import current_figure, readings_of, series_of, voltage_figure
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Drawn, Section
from labrig.report.sections.interface import ReportSection
from labrig.report.tables.paper import table_3
from model import Condition, Measurements

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def make(findings: Findings, figures: FigureFolder) -> Section | str:
    """Return the sheets' table and the figures of what was measured."""
    measurements, names = findings.measurements, findings.names
    if measurements is None:
        return f"Nothing could be measured: {findings.why_not}"
    if not names:
        return Section()
    return Section(
        (
            table_3(measurements, names, findings.fit),
            *_signals(findings, measurements, figures),
            *_curves(findings, measurements, figures),
        )
    )


def _signals(
    findings: Findings, measurements: Measurements, figures: FigureFolder
) -> Iterator[Drawn]:
    all_series = (series_of(measurements, name) for name in findings.names)
    series = next((one for one in all_series if one is not None), None)
    if series is None:
        return
    half_s = _half_window_s(findings)
    shaded = " The shaded time is that of each reading's symmetric filter." if half_s else ""
    yield from figures.draw(
        "figure-5",
        "Figure 5. Input voltage and times of the readings",
        "The sheet's voltage as read back, and the sampling points." + shaded,
        lambda: voltage_figure(measurements, series, half_s),
    )
    if series.current_A is not None:
        yield from figures.draw(
            "figure-6",
            f"Figure 6. Output current, {series.configuration} sheet",
            "The current that the voltage of figure 5 drives through the sheet.",
            lambda: current_figure(series, readings_of(measurements, series)),
        )


def _half_window_s(findings: Findings) -> float:
    """Of the readings' filter, as planned."""
    windows = [r.half_window_s for run in findings.session.runs for r in run.planned.readings]
    return max(windows, default=0.0)


def _curves(
    findings: Findings, measurements: Measurements, figures: FigureFolder
) -> Iterator[Drawn]:
    if all(c.curve is None for c in measurements.conditions):
        return
    yield from figures.draw(
        "figure-7",
        "Figure 7. Neutral curves as measured",
        "At all positions and voltages, from the mean image of each condition. Numbers: the "
        "load cell's position on the arc, mm. Thin lines: the rigid elongation.",
        lambda: curves_figure(measurements, findings.names),
    )
    yield from figures.draw(
        "frames",
        "Frames",
        "Mean image of a condition's frames, and the neutral curve found in it.",
        lambda: _frames(findings, _shown_frames(findings, measurements)),
    )


def _shown_frames(findings: Findings, measurements: Measurements) -> list[Condition]:
    """Return a strongly bent condition of each configuration: highest voltage and position."""
    chosen = []
    for name in findings.names:
        own = [c for c in measurements.conditions if c.configuration == name]
        seen = [c for c in own if c.curve is not None and c.used()]
        if seen:
            chosen.append(max(seen, key=lambda c: (c.voltage_V, c.position_m or 0.0)))
    return chosen


def _frames(findings: Findings, chosen: list[Condition]) -> Figure | None:
    from labrig.vision import Optics

    session = findings.session
    if session.frame_shape is None or "optics.json" not in session.texts:
        return None
    try:
        optics = Optics.from_json(session.texts["optics.json"])
    except BadInputError:
        return None
    return frame_figure(session, optics, chosen)


SECTION = ReportSection(
    title="Experiment",
    order=10,
    applies=lambda _findings: True,
    make=make,
    figures=("figure-5", "figure-6", "figure-7", "frames"),
)
