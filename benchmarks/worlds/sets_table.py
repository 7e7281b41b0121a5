"""How often the reported sets of answers hold the truth, how large they are, how true their odds.

A line for the questions of each family; a question is a place in a verdict (`right_answers`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.score import Row, mean_at_most, wilson
from benchmarks.worlds.fit_answers import COVERAGE
from benchmarks.worlds.right_answers import Labelled, labelled
from model.discrepancy.answers.calibrated_answers import CalibratedAnswers
from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN

SURE, LARGEST_SET = 0.9, 1.3
BINS = (0.0, 0.2, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0)


def rows(records: Sequence[Record], answers: CalibratedAnswers) -> list[Row]:
    """Return the lines: truth in the set and its size by kind of truth, and by probability."""
    asked = [(r.key, q) for r in records for q in labelled(r)]
    kinds: dict[str, Callable[[Labelled], bool]] = {
        "a name": lambda q: not q.right & {UNKNOWN, NOTHING},
        "unknown": lambda q: UNKNOWN in q.right,
        "nothing": lambda q: NOTHING in q.right,
        "any": lambda q: bool(q.right),
    }
    lines = []
    for what, chosen in kinds.items():
        some = [(key, q) for key, q in asked if chosen(q)]
        sizes = [len(answers.judged(q.asked).answers) for _, q in some]
        lines += [
            _share(f"truth: {what}; in the set", COVERAGE, some, answers),
            mean_at_most(f"truth: {what}; mean size of the set", LARGEST_SET, sizes),
        ]
    return [*lines, _sure(asked, answers), *_reliability(asked, answers)]


def _share(
    what: str, least: float, some: Sequence[tuple[str, Labelled]], answers: CalibratedAnswers
) -> Row:
    told = [(key, bool(q.right & {*answers.judged(q.asked).answers})) for key, q in some]
    return _row(what, f">= {least:.0%}", told, lambda share: share >= least)


def _sure(asked: Sequence[tuple[str, Labelled]], answers: CalibratedAnswers) -> Row:
    """An answer with a probability of 0.9 or more that is not right."""
    told = []
    for key, q in asked:
        first, p = next(iter(answers.probabilities(q.asked).items()))
        told.append((key, p >= SURE and first not in q.right))
    return _row(f"confidently wrong ({SURE:g})", "<= 1%", told, lambda share: share <= 0.01)


def _reliability(asked: Sequence[tuple[str, Labelled]], answers: CalibratedAnswers) -> list[Row]:
    """How often the likeliest answer is right, by its probability."""
    told = []
    for key, q in asked:
        first, p = next(iter(answers.probabilities(q.asked).items()))
        told.append((key, p, first in q.right))
    result = []
    for low, high in pairwise(BINS):
        own = [(k, p, ok) for k, p, ok in told if low <= p < high or p == high == 1.0]
        mean = float(np.mean([p for _, p, _ in own])) if own else 0.0
        what = f"likeliest answer right, where its probability is {low:g} - {high:g}"
        result.append(_row(what, f"{mean:.1%}", [(k, ok) for k, _, ok in own]))
    return result


def _row(
    what: str, goal: str, told: Sequence[tuple[str, bool]],
    met: Callable[[float], bool] | None = None,
) -> Row:  # fmt: skip
    """A share with its interval; without `met` the interval must hold the goal."""
    hits, count = sum(ok for _, ok in told), len(told)
    if not count:
        return Row(what, goal, "-", 0)
    low, high = wilson(hits, count)
    good = met(hits / count) if met else low <= float(goal.rstrip("%")) / 100.0 <= high
    return Row(what, goal, f"{hits / count:.1%}", count, f"{low:.1%} - {high:.1%}", good)
