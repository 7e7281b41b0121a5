"""Models of the sheet in time, as labrig compare has kept them in the session."""

from __future__ import annotations

from labrig.analysis.comparison import kept_comparisons, why_not_in_time
from labrig.report.data.findings import Findings
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Section
from labrig.report.sections.interface import ReportSection
from labrig.report.tables.dynamic_comparison import dynamic_comparison_table, not_fitted


def applies(findings: Findings) -> bool:
    """Whether models were compared in time, or could be."""
    session = findings.session
    if findings.measurements is None:
        return False
    if kept_comparisons(session.path):
        return True
    names = dict.fromkeys(run.planned.configuration for run in session.runs if run.started)
    return any(not why_not_in_time(session, name) for name in names)


def make(findings: Findings, _figures: FigureFolder) -> Section | str:
    """Return a table for each configuration."""
    found = kept_comparisons(findings.session.path)
    if not found:
        return (
            "Force, current and a free sheet that moves were recorded: labrig compare"
            f" {findings.session.path.name} fits nine models from the literature and labrig's"
            " moving sheet to them, and keeps the result for this page."
        )
    sentences = [text for one in found for text in (*not_fitted(one), *one.missing)]
    return Section(
        tuple(dynamic_comparison_table(one) for one in found), sentences=tuple(sentences)
    )


SECTION = ReportSection(title="Models in time", order=32, applies=applies, make=make)
