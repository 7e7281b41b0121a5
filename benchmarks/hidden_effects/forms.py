"""What a form of a hidden effect is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.hidden_effects.recipe import Recipe

Change = Callable[[Recipe, float], None]


@dataclass(frozen=True)
class Form:
    """One way in which an effect can be there."""

    effect: str
    form: str
    unit: str  # of the size, and what it says
    size: float  # a realistic one: a gap of some tenths of a millinewton where forces feel it
    largest: float  # that makes sense
    change: Change
    slot: str
    accepted: tuple[str, ...] = ()  # further slots that are no wrong answer
    place_mm: tuple[float, float] | None = None  # from .. to along the sheet
    # values of the catalogue's parameters, where this form has them
    parameters: Callable[[float], dict[str, float]] = lambda _: {}
    felt_by: str = "force"  # or only the curve
    symmetric: bool = False  # makes sense only where one |EIBM| serves both polarities


def set_to(key: str, by: float = 1.0) -> Change:
    """A change that sets one key to the size times a factor."""
    return lambda recipe, size: recipe.set(key, by * size)
