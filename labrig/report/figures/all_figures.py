"""All figures of a report: drawn, written as PNG and SVG, and handed on for the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from labrig.errors import BadInputError
from labrig.report.data.findings import Findings
from labrig.report.figures.comparison import comparison_figure
from labrig.report.figures.force import force_figure
from labrig.report.figures.frame import frame_figure
from labrig.report.figures.moment import moment_figure
from labrig.report.figures.shapes import curves_figure
from labrig.report.figures.signals import current_figure, readings_of, series_of, voltage_figure
from labrig.report.parts.style import save_pair
from labrig.report.parts.svg import inline
from labrig.report.tables.paper import compared_conditions
from model import Condition, ConfiguredSheet, Measurements

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Draw = Callable[[], "Figure | None"]


@dataclass(frozen=True)
class Drawn:
    """A figure of the page."""

    name: str  # of its files
    title: str
    caption: str
    svg: str


def draw_all(found: Findings, folder: Path) -> dict[str, Drawn]:
    """Every figure that the findings allow, by name; files of those they do not are removed."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = {}
    for name, (title, caption, draw) in _figures(found).items():
        fig = draw()
        if fig is None:
            continue
        save_pair(fig, folder, name)
        svg = (folder / f"{name}.svg").read_text(encoding="utf-8")
        drawn[name] = Drawn(name, title, caption, inline(svg, name, f"{title}. {caption}"))
    for name in NAMES:
        if name not in drawn:
            (folder / f"{name}.png").unlink(missing_ok=True)
            (folder / f"{name}.svg").unlink(missing_ok=True)
    return drawn


NAMES = ("frames", "figure-5", "figure-6", "figure-7", "figure-8", "figure-9", "table-5")


def _figures(found: Findings) -> dict[str, tuple[str, str, Draw]]:
    if found.measurements is None or not found.names:
        return {}
    return {name: figure for part in (_measured, _simulated) for name, figure in part(found)}


def _measured(found: Findings) -> Iterator[tuple[str, tuple[str, str, Draw]]]:
    measurements, names = found.measurements, found.names
    assert measurements is not None  # noqa: S101 - asked for before
    series = next((s for n in names if (s := series_of(measurements, n)) is not None), None)
    if series is not None:
        half_s = _half_window_s(found)
        shaded = " The shaded time is that of each reading's symmetric filter." if half_s else ""
        caption = "The sheet's voltage as read back, and the sampling points." + shaded
        yield (
            "figure-5",
            (
                "Figure 5. Input voltage and times of the readings",
                caption,
                lambda: voltage_figure(measurements, series, half_s),
            ),
        )
    if series is not None and series.current_A is not None:
        readings = readings_of(measurements, series)
        title = f"Figure 6. Output current, {series.configuration} sheet"
        caption = "The current that the voltage of figure 5 drives through the sheet."
        yield "figure-6", (title, caption, lambda: current_figure(series, readings))
    if any(c.curve is not None for c in measurements.conditions):
        caption = (
            "At all positions and voltages, from the mean image of each condition. Numbers: the "
            "load cell's position on the arc, mm. Thin lines: the rigid elongation."
        )
        title = "Figure 7. Neutral curves as measured"
        yield "figure-7", (title, caption, lambda: curves_figure(measurements, names))
        caption = "Mean image of a condition's frames, and the neutral curve found in it."
        chosen = _shown_frames(found, measurements)
        yield "frames", ("Frames", caption, lambda: _frames(found, chosen))


def _simulated(found: Findings) -> Iterator[tuple[str, tuple[str, str, Draw]]]:
    measurements, models, fit = found.measurements, found.fitted.models, found.fit
    assert measurements is not None  # noqa: S101 - asked for before
    caption = (
        "Points: means of the readings, bars: their standard deviation. "
        + "Lines: simulated with the EIBM that varies along the sheet, and with a constant one."
        * (models is not None)
    )
    title = "Figure 9. Forces, measured and simulated" if models else "Figure 9. Forces"
    yield "figure-9", (title, caption, lambda: force_figure(measurements, found.names, models))
    if models is None or fit is None:
        return
    fitted = [name for name in found.names if models.varying.sheets.get(name)]
    fitted = [name for name in fitted if _varies(models.varying.sheets[name])]
    if fitted:
        title = "Figure 8. Electrically induced bending moment along the sheet"
        caption = "The joint fit's EIBM with its 90 % interval, and the constant one (dashed)."
        yield "figure-8", (title, caption, lambda: moment_figure(models, fitted))
    compared = compared_conditions(measurements, fit)
    if compared:
        title = "Neutral curves of table 5"
        caption = (
            "Above: the bending part as measured and as simulated; y is enlarged. Below: distance "
            "of the measured points from the simulated curve."
        )
        yield (
            "table-5",
            (title, caption, lambda: comparison_figure(measurements, compared, models)),
        )


def _varies(sheet: ConfiguredSheet) -> bool:
    """Whether its EIBM is known to vary along it: without curves it is not."""
    return any(np.ptp(along.values) > 0 for along in sheet.eibm.values())


def _half_window_s(found: Findings) -> float:
    """Of the readings' filter, as planned."""
    windows = [r.half_window_s for run in found.session.runs for r in run.planned.readings]
    return max(windows, default=0.0)


def _shown_frames(found: Findings, measurements: Measurements) -> list[Condition]:
    """A strongly bent condition of each configuration: highest voltage, highest position."""
    chosen = []
    for name in found.names:
        own = [c for c in measurements.conditions if c.configuration == name]
        seen = [c for c in own if c.curve is not None and c.used()]
        if seen:
            chosen.append(max(seen, key=lambda c: (c.voltage_V, c.position_m or 0.0)))
    return chosen


def _frames(found: Findings, chosen: list[Condition]) -> Figure | None:
    from labrig.vision import Optics

    session = found.session
    if session.frame_shape is None or "optics.json" not in session.texts:
        return None
    try:
        optics = Optics.from_json(session.texts["optics.json"])
    except BadInputError:
        return None
    return frame_figure(session, optics, chosen)
