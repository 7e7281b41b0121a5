"""What `labrig curves` is told on the command line of several strips."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from labrig.errors import BadInputError
from labrig.vision.facts.values import POINT

if TYPE_CHECKING:
    from labrig.vision.calibration.optics import StripPlace

_STRIP = re.compile(rf"([A-Za-z0-9][A-Za-z0-9_-]{{0,39}})={POINT}(?::{POINT})?")


def strips_of(stated: list[str] | None) -> dict[str, StripPlace] | None:
    """Return the strips of each --strip by their names; None: those of optics.json."""
    if not stated:
        return None
    found: dict[str, StripPlace] = {}
    for each in stated:
        name, place = _strip(each)
        if name in found:
            raise BadInputError(f"--strip '{each}': there is a strip '{name}' already.")
        found[name] = place
    return found


def _strip(stated: str) -> tuple[str, StripPlace]:
    from labrig.config.base import validate
    from labrig.vision.calibration.optics import StripPlace

    match = _STRIP.fullmatch(stated.strip())
    if match is None:
        raise BadInputError(
            f"--strip '{stated}': give NAME=U,V (column and row of the clamp) or NAME=U,V:U,V."
        )
    name, *numbers = match.groups()
    clamp, along = numbers[:2], numbers[2:]
    data: dict[str, object] = {"clamp_px": [float(each) for each in clamp]}
    if along[0] is not None:
        data["along_px"] = [float(each) for each in along]
    return name, validate(StripPlace, data, f"--strip '{stated}'")
