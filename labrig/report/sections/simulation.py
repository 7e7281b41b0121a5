"""Simulation and measurement: forces (figure 9), curves (table 5), errors (table 6)."""

from __future__ import annotations

from collections.abc import Iterator

from labrig.report.data.findings import Findings
from labrig.report.data.models import HELD
from labrig.report.figures.comparison import comparison_figure
from labrig.report.figures.force import force_figure
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Drawn, Folded, Item, Section
from labrig.report.sections.interface import ReportSection
from labrig.report.tables.baselines import baseline_table
from labrig.report.tables.fit import residual_table
from labrig.report.tables.observations import observations
from labrig.report.tables.paper import compared_conditions, table_5, table_6
from model import Fit, Measurements


def make(findings: Findings, figures: FigureFolder) -> Section | str:
    """Return the figures and tables that the findings allow."""
    return Section(tuple(_items(findings, figures)))


def _items(findings: Findings, figures: FigureFolder) -> Iterator[Item]:
    fit, measurements = findings.fit, findings.measurements
    if measurements is not None and findings.names:
        yield from _forces(findings, measurements, figures)
    if fit is not None and measurements is not None:
        yield from _curves(findings, measurements, fit, figures)
        yield table_6(fit)
    if measurements is not None and findings.names:
        yield observations(measurements, fit)
    if findings.baselines:
        yield baseline_table(findings.baselines)
    if fit is not None:
        table = residual_table(fit)
        yield Folded(table.title, table)


def _forces(
    findings: Findings, measurements: Measurements, figures: FigureFolder
) -> tuple[Drawn, ...]:
    models = findings.fitted.models
    lines = f"Lines: simulated. {HELD}"
    return figures.draw(
        "figure-9",
        "Figure 9. Forces, measured and simulated" if models else "Figure 9. Forces",
        "Points: means of the readings, bars: their standard deviation. "
        + lines * (models is not None),
        lambda: force_figure(measurements, findings.names, models),
    )


def _curves(
    findings: Findings, measurements: Measurements, fit: Fit, figures: FigureFolder
) -> Iterator[Item]:
    compared, models = compared_conditions(measurements, fit), findings.fitted.models
    if not compared or models is None:
        return
    yield table_5(fit, compared)
    yield from figures.draw(
        "table-5",
        "Neutral curves of table 5",
        "Above: the bending part, measured and simulated; y is enlarged. Below: distance of the "
        f"measured points from the simulated curve. {HELD}",
        lambda: comparison_figure(measurements, compared, models),
    )


SECTION = ReportSection(
    title="Simulation and measurement",
    order=30,
    applies=lambda findings: findings.measurements is not None,
    make=make,
    figures=("figure-9", "table-5"),
)
