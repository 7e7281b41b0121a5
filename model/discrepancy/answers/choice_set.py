"""A choice set: the possible answers to one question of a verdict, with their attributes.

A verdict answers one question for each name that it considers (which effect is it?) and a last one
(is anything else not in the model?). The answers to a question are a choice set (McFadden 1974):
names of the catalogue, `UNKNOWN` and `NOTHING`, each with attributes. All attributes are numbers of
the order of one; logarithms of 1 + x stand for evidence, which grows with the square of an effect.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

UNKNOWN = "unknown"  # something that no effect of the catalogue describes
NOTHING = "nothing"  # no effect, or none besides those that are named

ATTRIBUTES = {
    # of a name of the catalogue
    "behind": "ln(1 + log Bayes factor of the best name over it)",
    "behind_share": "that log Bayes factor over the evidence of the best name",
    "first": "the best name",
    "considered": "named by the search",
    "not_fitted": "its evidence is that of the linearised model",
    "form_share": "share of its contribution that is model-form error",
    "votes": "share of the left-out positions without which it is chosen, the other names in place",
    "large": "log10 of its amplitude over the prior scale, where that is above 1",
    "freedom": "ln of the number of its columns, the ways in which its form may differ included",
    "beside": "the search names something else, too",
    "failed": "checks that it fails, 3 at most",
    "misfit": "ln of the largest chi^2 per number on left-out positions, of a quantity; at least 0",
    "uneven": "largest sure difference of its amplitude in a part of the data, as a share of it",
    # of something unknown
    "unknown": "1",
    "unknown_considered": "called unknown by the search",
    "unknown_ahead": "ln(1 + log Bayes factor of the best nonparametric term over the best name)",
    "unknown_ahead_share": "that log Bayes factor over the larger of the two",
    "unexplained": "ln(1 + evidence of a nonparametric term beside the names)",
    "unexplained_share": "share of the excess evidence that it has",
    "scatter": "ln of the largest random effect over its usual size, beside the names",
    "unknown_failed": "checks that fail, 3 at most",
    # of nothing
    "nothing": "1",
    "nothing_further": "something is named already",
    "nothing_considered": "called nothing by the search",
    "nothing_gain": "ln(1 + evidence of the best alternative)",
    "nothing_apart": "the same, the effects that are named being uncertain by a few per cent",
}  # by name


@dataclass(frozen=True)
class Alternative:
    """An answer with its attributes; those that are not there are 0."""

    name: str
    attributes: Mapping[str, float]


@dataclass(frozen=True)
class ChoiceSet:
    """The answers to one question of a verdict."""

    considered: str  # what the search names here; `NOTHING` or `UNKNOWN` in the last one
    alternatives: tuple[Alternative, ...]

    def to_json(self) -> dict[str, Any]:
        """Return its object in a benchmark's record."""
        return {
            "considered": self.considered,
            "alternatives": {
                one.name: {k: round(v, 4) for k, v in one.attributes.items()}
                for one in self.alternatives
            },
        }

    @staticmethod
    def from_json(kept: Mapping[str, Any]) -> ChoiceSet:
        """Return the choice set of an object."""
        every = kept["alternatives"].items()
        return ChoiceSet(kept["considered"], tuple(Alternative(n, dict(a)) for n, a in every))
