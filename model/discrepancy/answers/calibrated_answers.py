"""Calibrated probabilities of answers, and sets that hold the right one in 95 % of training cases.

The probability of answer a of a choice set is a conditional logit (McFadden 1974, in Frontiers in
Econometrics),

    P(a) = exp(w . x_a) / sum_b exp(w . x_b),

with the attributes x and weights w that were fitted to sessions in which it is known what is
hidden. A set has the likeliest answers, until they have a probability together that is its content
(adaptive prediction sets; Romano, Sesia and Candes 2020, Adv. Neural Inf. Process. Syst. 33). The
content is as much as it takes for the sets to hold the right answer in 95 % of the training
questions, with weights that were fitted to other worlds, and 0.9 at least. Where the search says
something and where it says NOTHING sets have contents of their own, so that the promise holds for
whoever reads one or the other. Where it says UNKNOWN the content is 0.95 at least: what no form of
the catalogue describes may be another form of one of its names. The numbers are in
`calibrated_answers.json`, made by `python -m benchmarks.worlds.calibrate`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN, ChoiceSet
from model.discrepancy.thresholds import LEAST_CONTENT_OF_UNKNOWN

FILE = Path(__file__).with_name("calibrated_answers.json")
SOMETHING = "something"  # a name, or `UNKNOWN`
REPORTED = (SOMETHING, NOTHING)


def reported(one: ChoiceSet) -> str:
    """Return whether the search says something, or nothing."""
    return NOTHING if one.considered == NOTHING else SOMETHING


def is_name(answer: str) -> bool:
    """Return whether an answer is an effect of the catalogue."""
    return answer not in (UNKNOWN, NOTHING)


@dataclass(frozen=True)
class Judged:
    """A choice set with its probabilities and the set that is reported."""

    probabilities: Mapping[str, float]  # of every answer, likeliest first; they add up to one
    answers: tuple[str, ...]  # the set, likeliest first

    @property
    def likeliest(self) -> str:
        """The answer of the largest probability."""
        return next(iter(self.probabilities))

    @property
    def of_names(self) -> float:
        """The probability that it is some effect of the catalogue."""
        return sum(p for name, p in self.probabilities.items() if is_name(name))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the catalogue in the set."""
        return tuple(one for one in self.answers if is_name(one))


@dataclass(frozen=True)
class CalibratedAnswers:
    """Weights of attributes, and how much probability a set has."""

    weights: Mapping[str, float]
    contents: Mapping[str, float]  # by what the search says

    def judged(self, one: ChoiceSet) -> Judged:
        """Return the probabilities of a choice set, and its answers."""
        chances, content = self.probabilities(one), self.contents[reported(one)]
        if one.considered == UNKNOWN:
            content = max(content, LEAST_CONTENT_OF_UNKNOWN)
        before = likelier(chances)
        return Judged(chances, tuple(name for name in chances if before[name] <= content))

    def probabilities(self, one: ChoiceSet) -> dict[str, float]:
        """Return the probability of each answer, likeliest first."""
        utility = np.array([
            sum(self.weights.get(k, 0.0) * v for k, v in a.attributes.items())
            for a in one.alternatives
        ])  # fmt: skip
        weights = np.exp(utility - np.max(utility))
        chances = (weights / weights.sum()).tolist()
        pairs = zip((a.name for a in one.alternatives), chances, strict=True)
        return dict(sorted(pairs, key=lambda pair: -pair[1]))


def likelier(chances: Mapping[str, float]) -> dict[str, float]:
    """Return the probability of all answers before each one, the likeliest coming first."""
    before = np.concatenate([[0.0], np.cumsum(list(chances.values()))[:-1]])
    return dict(zip(chances, before.tolist(), strict=True))


@cache
def calibrated() -> CalibratedAnswers:
    """Return the numbers of the file."""
    kept = json.loads(FILE.read_text(encoding="utf-8"))
    return CalibratedAnswers(kept["weights"], kept["contents"])
