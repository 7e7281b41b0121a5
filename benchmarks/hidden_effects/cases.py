"""What a session is to be like: what is hidden in it, and how well it was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

NOTHING = "nothing"
Rest = Literal["exp", "nodes", "constant"]


@dataclass(frozen=True)
class Hiding:
    """One hidden effect. `form` "": its first one; `size` None: a realistic one."""

    effect: str
    form: str = ""
    size: float | None = None


@dataclass(frozen=True)
class Extras:
    """What is measured beyond 7 positions x 2 configurations in rising order."""

    free_shapes: bool = False  # six of each configuration, load cell away
    remounts: int = 0  # positions of each configuration that are set anew
    random_order: bool = False  # of the positions
    reversed_approach: bool = False  # the middle position again, from the other side
    no_touch_zero: bool = False  # the load cell's zero before each position, without contact


@dataclass(frozen=True)
class Case:
    """One session. The same case gives the same data, bit by bit."""

    hidden: tuple[Hiding, ...] = ()
    seed: int = 0
    # "means": readings without times, no curve of a single reading, no series
    streams: Literal["all", "means"] = "all"
    scatter: float = 1.0  # of the set-ups, over the usual one
    outlier: bool = False  # one run was set up badly
    correlated: bool = False  # the load cell wanders more, and repeats are alike
    rest: Rest = "exp"  # how k0 goes along the long sheet; sheet.toml states it to match
    symmetric: bool = False  # |EIBM(-2 V)| = |EIBM(+2 V)| where nothing is hidden
    extras: Extras = Extras()
    series_hz: float = 100.0
    further: str = ""  # an entry of the menu of further measurements, measured instead

    @property
    def name(self) -> str:
        """The hidden effects, or "nothing"."""
        return " + ".join(h.effect for h in self.hidden) or NOTHING

    @property
    def bare(self) -> Case:
        """The same session with nothing hidden in it."""
        return replace(self, hidden=())


def case(effect: str = NOTHING, form: str = "", size: float | None = None, **options: Any) -> Case:
    """A case with one hidden effect, or with "nothing". `options` are those of `Case`."""
    hidden = () if effect == NOTHING else (Hiding(effect, form, size),)
    return Case(hidden, **options)
