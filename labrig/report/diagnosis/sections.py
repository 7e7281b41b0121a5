"""What a diagnosis found, as sections of a page."""

from __future__ import annotations

from collections.abc import Mapping

from labrig.report.diagnosis import tables as made
from labrig.report.figures.all_figures import Drawn
from labrig.report.parts.section import Folded, Section
from labrig.report.parts.table import Table
from model.discrepancy.verdict.result import Diagnosis

Figures = Mapping[str, Drawn]
Items = tuple[Table | Drawn | Folded, ...]


def sections_of(found: Diagnosis, drawn: Figures) -> list[Section]:
    """All of it, in the order in which a person asks."""
    left = (made.gap_sentence(found),)
    parts = [
        Section("Finding", _finding(found, drawn), tuple(made.verdict_sentences(found))),
        Section(
            "Where it shows", (made.where_table(found), *_those(drawn, "diagnosis-maps")), left
        ),
        Section(
            "Before and after",
            (made.improvement_table(found), *_those(drawn, "diagnosis-forces", "diagnosis-curves")),
        ),
        Section("Candidates", (made.ranking_table(found), *_those(drawn, "diagnosis-ranking"))),
        Section("What these data can tell apart", _sight(found, drawn), tuple(_said(found))),
        Section("What to measure next", (), tuple(made.next_sentences(found))),
    ]
    return [part for part in parts if part.items or part.sentences]


def _finding(found: Diagnosis, drawn: Figures) -> Items:
    table = made.parameter_table(found)
    return (*([] if table is None else [table]), *_those(drawn, "diagnosis-form"))


def _sight(found: Diagnosis, drawn: Figures) -> Items:
    table = made.invisible_table(found)
    return (*([] if table is None else [table]), *_those(drawn, "diagnosis-signatures"))


def _said(found: Diagnosis) -> list[str]:
    scatter = made.scatter_sentence(found)
    return [
        *made.visibility(found),
        *([scatter] if scatter else []),
        *made.further_sentences(found),
    ]


def _those(drawn: Figures, *names: str) -> list[Drawn]:
    return [drawn[name] for name in names if name in drawn]


def findings_in_short(found: Diagnosis, drawn: Figures) -> Section:
    """One section for the report of a session."""
    sight = made.invisible_table(found)
    items: list[Table | Drawn | Folded] = list(_finding(found, drawn))
    items += [made.improvement_table(found)]
    items += _those(drawn, "diagnosis-maps", "diagnosis-forces", "diagnosis-curves")
    ranking, where = made.ranking_table(found), made.where_table(found)
    items += [Folded(where.title, where), Folded(ranking.title, ranking)]
    if sight is not None:
        items.append(Folded(sight.title, sight))
    sentences = (
        made.gap_sentence(found),
        *made.verdict_sentences(found),
        *_said(found),
        *made.next_sentences(found),
    )
    return Section("What the model is missing", tuple(items), sentences)
