"""The result of a verdict check: its failures and its reported outcome."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class Consequence(StrEnum):
    """What a failure means for the names that it concerns."""

    REJECT = "reject"
    """They are dropped. Without names: something else is not in the model."""

    REJECT_UNLESS_PROBABLE = "reject_unless_probable"
    """They are dropped unless they are probable although a check failed; then 'unknown' is in
    their set."""

    IMPROBABLE_AMPLITUDE = "improbable_amplitude"
    """They are less probable, as people would notice the amplitude; 'unknown' is in their set."""

    EQUIVALENCE_CLASS = "equivalence_class"
    """The rivals explain the data as well, and are in their set. It counts against the names."""

    INDISTINGUISHABLE = "indistinguishable"
    """The data do not tell them from the rivals, which share their probability as the odds say. It
    counts against none of them."""

    REMARK = "remark"
    """None. The sentence is reported."""

    INCONCLUSIVE = "inconclusive"
    """The data allow no verdict, whatever is named: it is `cannot_tell`."""


@dataclass(frozen=True, kw_only=True)
class Failure:
    """Something that contradicts a verdict."""

    consequence: Consequence
    sentence: str  # what contradicts what, without its full stop
    effects: tuple[str, ...] = ()  # names that it concerns; none: all of them together
    rivals: tuple[str, ...] = ()  # names that explain the data as well, or are indistinguishable
    odds: tuple[float, ...] = ()  # of those indistinguishable: their probability over the name's
    overlooked: float = 1.0  # of an improbable amplitude: probability that nobody noticed it

    def __post_init__(self) -> None:
        """Raise ValueError for a consequence that there is not."""
        if self.consequence not in list(Consequence):
            known = ", ".join(Consequence)
            raise ValueError(f"there is no consequence '{self.consequence}'; there are {known}")


@dataclass(frozen=True, kw_only=True)
class CheckResult:
    """What a check said of a verdict."""

    name: str
    passed: bool
    sentence: str  # what was compared, or what failed
    effects: tuple[str, ...] = ()  # names that a failure concerns

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "name": self.name, "passed": self.passed, "sentence": self.sentence,
            "effects": list(self.effects),
        }  # fmt: skip
