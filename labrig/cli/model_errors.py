"""What a command that uses a model says of how far the model is from its own data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from labrig.cli.screen import say, warn

if TYPE_CHECKING:
    from model import SheetModel
    from model.sheet.misfit import Misfit


def errors_of(model: SheetModel, names: Iterable[str]) -> list[Misfit]:
    """Return how far the model is from its data, by configuration."""
    from model.sheet.misfit import misfit

    return [misfit(model, name) for name in names]


def warn_of_misses(found: Iterable[Misfit]) -> None:
    """Warn of each configuration whose model does not describe its own data."""
    for one in found:
        if one.misses:
            better = f", {one.better_in_words}" if one.known_better else ""
            warn(
                f"warning: the model of '{one.configuration}' misses its own data by "
                f"{one.in_words} RMS; take fit --varying (EIBM along the sheet{better}) "
                "or diagnose -o."
            )


def say_errors(found: Iterable[Misfit]) -> None:
    """Print the errors at the conditions that the model was fitted to, where they are known."""
    known = [f"{one.configuration} {one.in_words}" for one in found if one.in_words]
    if known:
        say(f"errors of the model at the data it was fitted to, RMS: {', '.join(known)}")
