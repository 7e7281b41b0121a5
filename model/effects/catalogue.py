"""Find the effects: one a file of this folder, and those of other distributions.

A file of this folder adds one by its constant `EFFECT`; another distribution by an entry point of
the group `labrig.effects`.
"""

from __future__ import annotations

import sys
import warnings
from functools import lru_cache

from model.effects.interface import Effect
from model.locations import locations
from model.measurements import ModelError
from model.plugins import OWN, Part, PluginFolder, PluginWarning, UnknownPartError


def _faults(part: object) -> list[str]:
    from model.effects.conformance import faults

    return faults(part)


FOLDER: PluginFolder[Effect] = PluginFolder(
    what="effect",
    package="model.effects",
    constant="EFFECT",
    group="labrig.effects",
    faults=_faults,
)


def catalogue() -> dict[str, Effect]:
    """Return all effects by name: ours by location, then by name, then other people's.

    One that cannot be used is left out with a warning.
    """
    return {name: part.part for name, part in _found(tuple(sys.path)).items()}


def title(name: str) -> str:
    """Return what readers are shown of an effect or candidate: its title, or its name in words."""
    known = catalogue().get(name)
    own = "" if known is None else known.title
    words = name.replace("unknown:", "unknown, ").replace("_", " ").split(" ")
    return own or " ".join("EIBM" if word == "eibm" else word for word in words)


def effect(name: str) -> Effect:
    """Return the effect of this name; a `ModelError` lists those there are."""
    known = catalogue()
    if name in known:
        return known[name]
    try:
        return FOLDER.get(name)
    except UnknownPartError as error:
        text = str(error)
        hint = "" if "did you mean" in text else ": `labrig effects` lists them"
        raise ModelError(text + hint) from None


def origins() -> dict[str, str]:
    """Return "distribution version" by name of the effects of other distributions."""
    return {
        name: f"{part.distribution} {part.version}"
        for name, part in _found(tuple(sys.path)).items()
        if part.distribution != OWN
    }


@lru_cache(maxsize=4)
def _found(path: tuple[str, ...]) -> dict[str, Part[Effect]]:
    """Return the parts by the names of their effects, as seen from these places."""
    del path
    order = list(locations())
    parts = sorted(
        FOLDER.parts().values(),
        key=lambda p: (p.distribution != OWN, order.index(p.part.location), p.part.name),
    )
    result: dict[str, Part[Effect]] = {}
    for part in parts:
        name = part.part.name
        if name in result:
            warnings.warn(
                f"the effect '{part.name}' of {part.distribution} is left out: there is an effect"
                f" '{name}' already; give it another name.", PluginWarning, stacklevel=3,
            )  # fmt: skip
        else:
            result[name] = part
    return result
