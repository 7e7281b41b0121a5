"""What `labrig curves` is told on the command line: masks and several strips."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.vision.calibration.optics import StripPlace
    from labrig.vision.image.mask import Polygons

_NUMBER = r"-?\d+(?:\.\d+)?"
_POINT = rf"({_NUMBER}),({_NUMBER})"
_STRIP = re.compile(rf"([A-Za-z0-9][A-Za-z0-9_-]{{0,39}})={_POINT}(?::{_POINT})?")


def masks_of(stated: list[str] | None) -> Polygons:
    """Return the polygons of each --mask. Raises BadInputError."""
    from labrig.vision.image.mask import read_mask

    return tuple(polygon for each in stated or () for polygon in read_mask(each))


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


def point_of(stated: str | None, option: str) -> tuple[float, float] | None:
    """Return column and row of "U,V"; None where it is not given. Raises BadInputError."""
    if stated is None:
        return None
    match = re.fullmatch(_POINT, stated.strip())
    if match is None:
        raise BadInputError(f"{option} '{stated}': give a pixel's column and row, U,V.")
    return float(match[1]), float(match[2])


def points_of(stated: str | None, option: str) -> tuple[tuple[float, float], ...]:
    """Return columns and rows of "U,V U,V ..."; empty where it is not given.

    Raises BadInputError.
    """
    found = []
    for each in (stated or "").split():
        match = re.fullmatch(_POINT, each)
        if match is None:
            raise BadInputError(f"{option} '{each}': give columns and rows of pixels, 'U,V U,V'.")
        found.append((float(match[1]), float(match[2])))
    return tuple(found)


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
