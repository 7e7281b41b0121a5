"""The sections of a diagnosis's own page, in the order of a reader's questions."""

from __future__ import annotations

from collections.abc import Mapping

from labrig.report.diagnosis import parameters, tables
from labrig.report.diagnosis.limits import limits_table
from labrig.report.parts.section import Drawn, Item, Section
from model.discrepancy.verdict.result import Diagnosis


def sections_of(found: Diagnosis, drawn: Mapping[str, Drawn]) -> list[Section]:
    """Return the sections that have something to show."""
    if not found.searched:  # there is no more than the reason
        said = (*tables.verdict_sentences(found), *tables.further_sentences(found))
        return [Section(sentences=said, title="Finding")]

    def figures(*names: str) -> list[Drawn]:
        return [drawn[name] for name in names if name in drawn]

    maps, fits = figures("diagnosis-maps"), figures("diagnosis-forces", "diagnosis-curves")
    parts = [
        Section(
            _present(
                parameters.parameter_table(found),
                parameters.choice_table(found),
                *figures("diagnosis-form"),
            ),
            tuple(tables.verdict_sentences(found)),
            title="Finding",
        ),
        Section(
            (tables.where_table(found), *maps),
            (tables.gap_sentence(found),),
            title="Residuals",
        ),
        Section((tables.improvement_table(found), *fits), title="Errors before and after"),
        Section(
            (tables.ranking_table(found), *figures("diagnosis-ranking")),
            title="Candidates",
        ),
        Section(
            _present(
                tables.invisible_table(found), limits_table(found), *figures("diagnosis-signatures")
            ),
            tuple(tables.limits_sentences(found)),
            title="Identifiability",
        ),
        Section(sentences=tuple(tables.next_sentences(found)), title="Next measurement"),
    ]
    return [part for part in parts if not part.is_empty]


def _present(*items: Item | None) -> tuple[Item, ...]:
    return tuple(item for item in items if item is not None)
