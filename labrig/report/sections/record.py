"""The record: what the session file says of itself, its versions, its event log."""

from __future__ import annotations

from dataclasses import replace

from labrig.report.data.findings import Findings
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Folded, Section
from labrig.report.parts.table import Table
from labrig.report.sections.interface import ReportSection
from labrig.report.tables.overview import overview


def make(findings: Findings, _figures: FigureFolder) -> Section | str:
    """Return the session's facts and checksums, its channels, and folded its log."""
    session = findings.session
    found = replace(overview(session), marks=())  # which have a section of their own
    facts, _, *channels, log = found.tables(log=True)
    sums = [("recorded data, sha256", session.checksum)]
    if findings.measurements is not None and findings.measurements.checksum:
        sums.append(("measurements were made from", findings.measurements.checksum))
    versions = tuple(sorted(session.versions.items()))
    return Section(
        (
            replace(facts, rows=(*facts.rows, *sums)),
            *channels,
            Table(title="Software", columns=("package", "version"), rows=versions, text=True),
            Folded(f"Event log, {len(log.rows)} lines", log),
        )
    )


SECTION = ReportSection(title="Record", order=70, applies=lambda _findings: True, make=make)
