"""The quality of the data: timing, losses, saturation, invalid readings, noise, all runs."""

from __future__ import annotations

from labrig.report.data.findings import Findings
from labrig.report.data.quality import MOST_WARNINGS
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Folded, Section
from labrig.report.parts.table import Table
from labrig.report.sections.interface import ReportSection
from labrig.report.tables.overview import overview


def make(findings: Findings, _figures: FigureFolder) -> Section | str:
    """Return the tables of quality, and folded the runs and warnings too many for the top."""
    runs = overview(findings.session).runs_table()
    folded = [Folded("All runs", runs)] if runs.rows else []
    warned = [] if findings.measurements is None else findings.measurements.warnings
    if len(warned) > MOST_WARNINGS:
        table = Table(title="", columns=("",), rows=tuple((text,) for text in warned))
        folded.append(Folded(f"All {len(warned)} warnings of the analysis", table))
    return Section((*findings.quality.tables, *folded))


SECTION = ReportSection(
    title="Quality of the data", order=50, applies=lambda _findings: True, make=make
)
