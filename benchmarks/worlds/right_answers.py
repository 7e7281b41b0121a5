"""Which answers of a diagnosis's choice sets are right, given what is hidden."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.score import IMITATED
from benchmarks.worlds.cases import MIXED
from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN, ChoiceSet

SEEN = 8.0  # sigma, from which on an effect can be seen for sure


@dataclass(frozen=True)
class Labelled:
    """A question of a verdict with its right answers; any of them is right."""

    world: str
    family: str
    asked: ChoiceSet
    right: frozenset[str]


def labelled(record: Record) -> list[Labelled]:
    """Return the questions of a case; none where nobody could tell, or something failed.

    A name that is there is the right answer where it is considered. Other questions, in the order
    of the search, are each about an effect that is left; further ones are about nothing. What no
    catalogue has may act in several places, so that further ones may be about it, too.
    """
    if record.error or not record.choice_sets or 0.0 < record.d < SEEN:
        return []
    asked = [ChoiceSet.from_json(one) for one in record.choice_sets]
    further = {NOTHING, UNKNOWN} if record.family in ("outside", MIXED) else {NOTHING}
    right = _right([one.considered for one in asked], _hidden(record), frozenset(further))
    world = record.key.split(":")[0]
    return [
        Labelled(world, record.family, one, answers)
        for one, answers in zip(asked, right, strict=True)
    ]


def _hidden(record: Record) -> list[frozenset[str]]:
    """Return the right answers about each thing that is hidden."""
    if record.family not in ("outside", MIXED):
        return [frozenset({name}) for name in record.names]
    alike = {n for n, left in record.left_tolerant.items() if left <= IMITATED}
    of_catalogue = [frozenset({name}) for name in record.names[:-1]]
    return [*of_catalogue, frozenset({UNKNOWN, *alike})]


def _right(
    considered: Sequence[str], hidden: Sequence[frozenset[str]], further: frozenset[str]
) -> list[frozenset[str]]:
    left, result = list(hidden), dict[int, frozenset[str]]()
    for i, name in enumerate(considered):
        own = next((one for one in left if name in one), None)
        if own is not None:
            left.remove(own)
            result[i] = own
    any_of, count = frozenset[str]().union(*left), len(left)
    for i in range(len(considered)):
        if i not in result:
            result[i] = any_of if count > 0 else further
            count -= 1
    return [result[i] for i in range(len(considered))]
