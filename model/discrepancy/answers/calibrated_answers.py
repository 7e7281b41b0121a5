"""Probabilities of answers, and sets that hold the right one in 95 % of an ensemble of worlds.

The probability of answer a of a choice set is a conditional logit (McFadden 1974, in Frontiers in
Econometrics),

    P(a) = exp(w . x_a) / sum_b exp(w . x_b),

with the attributes x and weights w that were fitted to sessions in which it is known what is
hidden. A set has every answer whose probability reaches a threshold: the quantile of the
probabilities that right answers had in worlds to which the weights were not fitted (conformal sets;
Vovk, Gammerman and Shafer 2005, Algorithmic Learning in a Random World; of this form they are the
smallest: Sadinle, Lei and Wasserman 2019, J. Am. Stat. Assoc. 114, 223). Each kind of what the
search says, a name, UNKNOWN, NOTHING, has its own threshold, so that the promise holds for whoever
reads one of them. The numbers are in `calibrated_answers.json`, made by
`python -m benchmarks.worlds.calibrate`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN, ChoiceSet

FILE = Path(__file__).with_name("calibrated_answers.json")
NAME = "name"  # the kind of all effects of the catalogue
KINDS = (NAME, UNKNOWN, NOTHING)


def kind_of(answer: str) -> str:
    """Return the kind of an answer."""
    return answer if answer in (UNKNOWN, NOTHING) else NAME


@dataclass(frozen=True)
class Judged:
    """A choice set with its probabilities and the set that is reported."""

    probabilities: Mapping[str, float]  # of every answer, likeliest first; they add up to one
    answers: tuple[str, ...]  # the set, likeliest first; at least the likeliest

    @property
    def likeliest(self) -> str:
        """The answer of the largest probability."""
        return next(iter(self.probabilities))

    @property
    def of_names(self) -> float:
        """The probability that it is some effect of the catalogue."""
        return sum(p for name, p in self.probabilities.items() if kind_of(name) == NAME)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the catalogue in the set."""
        return tuple(one for one in self.answers if kind_of(one) == NAME)


@dataclass(frozen=True)
class CalibratedAnswers:
    """Weights of attributes, and thresholds of probability."""

    weights: Mapping[str, float]
    thresholds: Mapping[str, float]  # by the kind of what the search says

    def judged(self, one: ChoiceSet) -> Judged:
        """Return the probabilities of a choice set, and its answers."""
        chances = self.probabilities(one)
        least = self.thresholds[kind_of(one.considered)]
        within = [name for name, p in chances.items() if p >= least]
        return Judged(chances, tuple(within) or tuple(list(chances)[:1]))

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


@cache
def calibrated() -> CalibratedAnswers:
    """Return the numbers of the file."""
    kept = json.loads(FILE.read_text(encoding="utf-8"))
    return CalibratedAnswers(kept["weights"], kept["thresholds"])
