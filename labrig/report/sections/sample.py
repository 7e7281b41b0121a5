"""Sample and people: what about.toml states of the experiment."""

from __future__ import annotations

from labrig.report.data.findings import Findings
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Section
from labrig.report.sections.interface import ReportSection
from labrig.report.tables.about import about_tables


def make(findings: Findings, _figures: FigureFolder) -> Section | str:
    """Return the tables of experiment, people and sample."""
    return Section(tuple(about_tables(findings.session.about)))


SECTION = ReportSection(
    title="Sample and people",
    order=5,
    applies=lambda findings: not findings.session.about.is_empty,
    make=make,
)
