"""What a command that uses a model says of how far the model is from its own data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from labrig.cli.screen import say

INSTRUMENTS = ("load_cell", "camera")  # locations of effects that leave the sheet as it is

if TYPE_CHECKING:
    from model import SheetModel
    from model.sheet.misfit import Misfit


def errors_of(model: SheetModel, names: Iterable[str]) -> list[Misfit]:
    """Return how far the model is from its data, by configuration."""
    from model.sheet.misfit import misfit

    return [misfit(model, name) for name in names]


def warn_of_misses(found: Iterable[Misfit]) -> None:
    """Warn of each configuration whose model does not describe its own data."""
    from labrig.api.simulate import tell_of_misses

    tell_of_misses(list(found))


def say_errors(found: Iterable[Misfit], model: SheetModel) -> None:
    """Print the errors at the conditions that the model was fitted to, where they are known."""
    known = [f"{one.configuration} {one.in_words}" for one in found if one.in_words]
    if not known:
        return
    say(f"errors of the model at the data it was fitted to, RMS: {', '.join(known)}")
    left_out = _in_time(model)
    if left_out:
        say(
            f"The prediction leaves out what changes along a run ({', '.join(left_out)}); the data "
            "have it, so these errors may be larger than those of the diagnosis."
        )


def say_as_seen(model: SheetModel) -> None:
    """Print that forces and shapes are those of the instruments, where the model has such effects.

    The sheet's own are what `labrig design` computes with.
    """
    from model.effects import effect, title

    names = [
        title(one.name)
        for one in model.effects
        if (one.location or effect(one.name).location) in INSTRUMENTS
    ]
    if names:
        say(
            f"F and shape are what load cell and camera show, with {', '.join(names)}; "
            "`labrig design` has the sheet's own."
        )


def _in_time(model: SheetModel) -> list[str]:
    """Return the titles of the effects that `simulate` at rest cannot have."""
    from model.effects import effect, title

    names = [one.name for one in model.effects if not one.location]
    return [title(name) for name in names if effect(name).location == "time"]
