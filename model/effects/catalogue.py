"""Finds the effects: one per module of this package, and those of other people's packages.

A module of this package is an effect's when it has an `EFFECT`. Another distribution adds one by an
entry point of the group `labrig.effects` that leads to an `Effect`.
"""

from __future__ import annotations

import pkgutil
import sys
import warnings
from functools import lru_cache
from importlib import import_module
from typing import TYPE_CHECKING

from model.effects.interface import LOCATIONS, Effect
from model.measurements import ModelError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "labrig.effects"


def catalogue() -> dict[str, Effect]:
    """All effects by name: by location, then by name; those of other distributions after our own.

    One that cannot be used is left out with a warning.
    """
    return dict(_found(tuple(sys.path)))


def effect(name: str) -> Effect:
    """The effect of this name; a `ModelError` when there is none."""
    known = catalogue()
    if name not in known:
        raise ModelError(
            f"there is no effect '{name}'; choose one of: {', '.join(sorted(known))}"
            f"{_meant(name, known)}"
        )
    return known[name]


def _meant(name: str, known: dict[str, Effect]) -> str:
    from difflib import get_close_matches

    close = get_close_matches(name, known, n=1)
    return f" (did you mean '{close[0]}'?)" if close else ""


@lru_cache(maxsize=4)
def _found(path: tuple[str, ...]) -> dict[str, Effect]:
    """The catalogue as seen from these places; what is installed there is read once."""
    from importlib.metadata import entry_points  # slow to import

    del path
    effects = {
        e.name: e for e in sorted(_own(), key=lambda e: (LOCATIONS.index(e.location), e.name))
    }
    for entry in sorted(entry_points(group=GROUP), key=lambda e: (e.name, e.value)):
        found = _loaded(entry)
        if isinstance(found, str):
            _warn(entry, found)
        elif found.name in effects:
            _warn(entry, f"there is an effect '{found.name}' already: give it another name")
        else:
            effects[found.name] = found
    return effects


def _own() -> list[Effect]:
    """Those of this package."""
    package = import_module(__package__)
    names = sorted(module.name for module in pkgutil.iter_modules(package.__path__))
    modules = [import_module(f"{__package__}.{name}") for name in names]
    return [module.EFFECT for module in modules if hasattr(module, "EFFECT")]


def _loaded(entry: EntryPoint) -> Effect | str:
    """The effect an entry point leads to, or what is wrong with it."""
    from model.effects.conformance import faults_of_form

    try:
        found = entry.load()
        if not isinstance(found, Effect):
            return f"it is of type {type(found).__name__}, not a model.effects.Effect"
        return "; ".join(faults_of_form(found)) or found
    except Exception as error:  # noqa: BLE001 - other people's code may raise anything
        return f"loading it failed with {type(error).__name__}: {error}"


def _warn(entry: EntryPoint, why: str) -> None:
    origin = f" of {entry.dist.name}" if entry.dist else ""
    text = " ".join(why.split())
    warnings.warn(
        f"the effect '{entry.name}'{origin} ({entry.value}) is left out: {text}.", stacklevel=5
    )
