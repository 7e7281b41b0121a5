"""Runs in which a controller set the voltage: force and voltage beside the linear model."""

from __future__ import annotations

from functools import partial

from labrig.control.controller_file import parse_controller
from labrig.control.reference import CONTROLLER
from labrig.report.data.findings import Findings
from labrig.report.figures.controlled import ControlledRun, controlled_figure
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Item, Section
from labrig.report.parts.table import Table, number
from labrig.report.sections.interface import ReportSection
from labrig.session import RunRecord

MOST_RUNS = 4  # that are drawn
NAMES = tuple(f"controlled-{k + 1}" for k in range(MOST_RUNS))


def controlled_runs(findings: Findings) -> list[RunRecord]:
    """Return the runs with at least two periods under control."""
    if CONTROLLER not in findings.session.texts:
        return []
    return [run for run in findings.session.runs if run.started and len(run.control) > 1]


def make(findings: Findings, figures: FigureFolder) -> Section | str:
    """Return a figure of each run, and a table."""
    session = findings.session
    controller = parse_controller(session.texts[CONTROLLER], CONTROLLER)
    limit_V = float(session.resolved["rig"]["limits"]["sheet_voltage_V"])
    items: list[Item] = []
    rows: list[tuple[str, ...]] = []
    for place, run in enumerate(controlled_runs(findings)):
        found = ControlledRun.of(run, controller, limit_V)
        title = f"Run {run.planned.index + 1}: {run.planned.configuration} under control"
        if place < MOST_RUNS:
            items += figures.draw(
                NAMES[place],
                title,
                "The linear model is that of controller.toml, under the same reference.",
                partial(controlled_figure, found),
            )
        rows += _rows(title, found)
    columns = ("", "RMS off the reference, mN", "largest, mN", "highest voltage, V", "at its limit")
    return Section(
        (*items, Table(title="Force against the reference", columns=columns, rows=tuple(rows)))
    )


def _rows(title: str, found: ControlledRun) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for what, force_N, voltage_V in (
        ("measured", found.force_N, found.voltage_V),
        ("linear model", found.linear_N, found.linear_V),
    ):
        rms_N, largest_N = found.off_N(force_N)
        highest = number(float(abs(voltage_V).max()))
        limited = f"{100 * found.limited(voltage_V):.0f} % of the time"
        rows.append(
            (f"{title}, {what}", number(1e3 * rms_N), number(1e3 * largest_N), highest, limited)
        )
    return rows


SECTION = ReportSection(
    title="Force under control",
    order=29,
    applies=lambda findings: bool(controlled_runs(findings)),
    make=make,
    figures=NAMES,
)
