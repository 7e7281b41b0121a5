"""Marks: which readings and runs were declared invalid, by whom, when and why."""

from __future__ import annotations

from labrig.report.data.findings import Findings
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Section
from labrig.report.sections.interface import ReportSection
from labrig.report.tables.marks import all_marks, marks_as_table


def make(findings: Findings, _figures: FigureFolder) -> Section | str:
    """Return all marks in one table, those made during the session first."""
    session = findings.session
    marks, later = all_marks(session), len(session.marks_after_end)
    count = f"{len(marks) - later} made during the session, {later} after its end."
    said = [f"{count} The last mark of a place counts; the recording itself stays as it is."]
    if session.outdated:
        said.append(session.outdated)
    return Section((marks_as_table(marks, title=""),), tuple(said))


SECTION = ReportSection(
    title="Marks",
    order=64,
    applies=lambda findings: bool(all_marks(findings.session)),
    make=make,
)
