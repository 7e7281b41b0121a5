"""The finding of `labrig diagnose`, where the session holds one, in one section."""

from __future__ import annotations

from labrig.report.data.findings import Findings
from labrig.report.diagnosis import checks, parameters, tables
from labrig.report.diagnosis.figures import FIGURES, draw_diagnosis
from labrig.report.diagnosis.limits import limits_table
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Folded, Item, Section
from labrig.report.sections.interface import ReportSection


def make(findings: Findings, figures: FigureFolder) -> Section | str:
    """Return the verdict, its parameters, what they improve and the candidates."""
    found = findings.diagnosis
    if found is None:
        return Section()
    if not found.searched:
        said = (*tables.verdict_sentences(found), *tables.further_sentences(found))
        return Section(sentences=said)
    drawn = draw_diagnosis(found, figures)
    folded = (
        checks.check_table(found), tables.where_table(found), tables.ranking_table(found),
        tables.invisible_table(found), limits_table(found),
    )  # fmt: skip
    items: tuple[Item | None, ...] = (
        parameters.parameter_table(found),
        parameters.choice_table(found),
        drawn.get("diagnosis-form"),
        tables.improvement_table(found),
        *(drawn.get(f"diagnosis-{name}") for name in ("maps", "forces", "curves")),
        *(Folded(table.title, table) for table in folded if table is not None),
    )
    sentences = (
        tables.gap_sentence(found),
        *tables.verdict_sentences(found),
        *tables.limits_sentences(found),
        *tables.next_sentences(found),
    )
    return Section(tuple(item for item in items if item is not None), sentences)


SECTION = ReportSection(
    title="Model discrepancy",
    order=40,
    applies=lambda findings: findings.diagnosis is not None,
    make=make,
    figures=tuple(FIGURES),
)
