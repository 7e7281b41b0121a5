"""How often the reported sets of answers hold the truth, how large they are, how true their odds.

A line for the questions of each family; a question is a place in a verdict (`right_answers`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.score import Row, mean_at_most
from benchmarks.worlds.fit_answers import COVERAGE
from benchmarks.worlds.reliability import Told, reliability, share
from benchmarks.worlds.right_answers import Labelled, labelled
from model.discrepancy.answers.calibrated_answers import CalibratedAnswers, is_name
from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN

SURE, LARGEST_SET = 0.9, 1.3


def rows(records: Sequence[Record], answers: CalibratedAnswers) -> list[Row]:
    """Return the lines: truth in the set and its size, by truth and by what is said; odds."""
    asked = [(r.key, q) for r in records for q in labelled(r)]
    kinds: dict[str, Callable[[Labelled], bool]] = {
        "truth: a name": lambda q: not q.right & {UNKNOWN, NOTHING},
        "truth: unknown": lambda q: UNKNOWN in q.right and NOTHING not in q.right,
        "truth: nothing": lambda q: NOTHING in q.right,
        "said: a name": lambda q: is_name(q.asked.considered),
        "said: unknown": lambda q: q.asked.considered == UNKNOWN,
        "said: nothing": lambda q: q.asked.considered == NOTHING,
        "all questions": lambda q: bool(q.right),
    }
    lines = []
    for what, chosen in kinds.items():
        some = [(key, q) for key, q in asked if chosen(q)]
        sizes = [len(answers.judged(q.asked).answers) for _, q in some]
        lines += [
            _share(f"{what}; truth in the set", COVERAGE, some, answers),
            mean_at_most(f"{what}; mean size of the set", LARGEST_SET, sizes),
        ]
    likeliest = _likeliest(asked, answers)
    wrong = [(key, p >= SURE and not right) for key, p, right in likeliest]
    return [
        *lines,
        share(f"confidently wrong ({SURE:g})", "<= 1%", wrong, lambda found: found <= 0.01),
        *reliability("likeliest answer right", likeliest),
    ]


def _share(
    what: str, least: float, some: Sequence[tuple[str, Labelled]], answers: CalibratedAnswers
) -> Row:
    told = [(key, bool(q.right & {*answers.judged(q.asked).answers})) for key, q in some]
    return share(what, f">= {least:.0%}", told, lambda found: found >= least)


def _likeliest(asked: Sequence[tuple[str, Labelled]], answers: CalibratedAnswers) -> list[Told]:
    """Return the probability of the likeliest answer to each question, and whether it is right."""
    judged = [(key, q, answers.judged(q.asked)) for key, q in asked]
    return [(key, j.probabilities[j.likeliest], j.likeliest in q.right) for key, q, j in judged]
