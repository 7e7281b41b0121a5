"""The result of a verdict check: its failures and its reported outcome."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

# unknown: the names are wrong, or something is not in the model that has no name
# noticed: people see such an amplitude as a rule, so the name is less probable; unknown is in its
#   set
# doubt: so it is, unless the answers, which count failed checks, are sure of the name all the same
# one_of: rivals are as good, the class is the answer
# alike: nothing in the data tells rivals apart; that speaks against none of them
# told: it is odd, and speaks against none of the names
# cannot_tell: the data do not allow a verdict
Consequence = Literal["unknown", "noticed", "doubt", "one_of", "alike", "told", "cannot_tell"]


@dataclass(frozen=True, kw_only=True)
class Failure:
    """Something that contradicts a verdict."""

    consequence: Consequence
    sentence: str  # what contradicts what, without its full stop
    effects: tuple[str, ...] = ()  # names that it concerns; none: all of them together
    rivals: tuple[str, ...] = ()  # of `one_of` and `alike`: names that are as good
    odds: tuple[float, ...] = ()  # of `alike`: probability of each rival over the name's
    overlooked: float = 1.0  # of `noticed`: the probability that nobody noticed

    def __post_init__(self) -> None:
        """Raise ValueError for a consequence that there is not."""
        if self.consequence not in get_args(Consequence):
            known = ", ".join(get_args(Consequence))
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
