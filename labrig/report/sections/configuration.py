"""The configuration files that the session was recorded with, word for word."""

from __future__ import annotations

from labrig.report.data.findings import Findings
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Folded, Section
from labrig.report.sections.interface import ReportSection


def make(findings: Findings, _figures: FigureFolder) -> Section | str:
    """Return each file as a folded text."""
    texts = sorted(findings.session.texts.items())
    return Section(tuple(Folded(name, text=text) for name, text in texts))


SECTION = ReportSection(
    title="Configuration",
    order=60,
    applies=lambda findings: bool(findings.session.texts),
    make=make,
)
