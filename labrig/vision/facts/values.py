"""Values of facts: points, polygons and flags, from the command line and from files."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TypeGuard

from labrig.errors import BadInputError

Point = tuple[float, float]
Polygon = tuple[Point, ...]

MOST_POINTS = 100
_NUMBER = r"-?\d+(?:\.\d+)?"
POINT = rf"({_NUMBER}),({_NUMBER})"


def point_of(stated: str) -> Point:
    """Return column and row of "U,V". Raises ValueError."""
    match = re.fullmatch(POINT, stated.strip())
    if match is None:
        raise ValueError("give a pixel's column and row, U,V")
    return float(match[1]), float(match[2])


def points_of(stated: str, option: str) -> tuple[Point, ...]:
    """Return columns and rows of "U,V U,V ...". Raises BadInputError."""
    found = []
    for each in stated.split():
        match = re.fullmatch(POINT, each)
        if match is None:
            raise BadInputError(f"{option} '{each}': give columns and rows of pixels, 'U,V U,V'.")
        found.append((float(match[1]), float(match[2])))
    return tuple(found)


def polygons_of(stated: str, option: str, key: str, noun: str) -> tuple[Polygon, ...]:
    """Return the polygons of a JSON file, or one written as "U,V U,V U,V".

    The file holds a list of polygons, or an object with that list under `key`. Raises
    BadInputError, which says that it is no `noun`.
    """
    from labrig.config.base import parse_json, read_text  # slow to import: pydantic

    path = Path(stated)
    where = stated
    listed: object
    if path.suffix.lower() == ".json" or _is_file(path):
        data = parse_json(read_text(path), stated)
        listed = data.get(key) if isinstance(data, dict) else data
    else:
        where = f"{option} '{stated}'"
        try:
            listed = [[[float(each) for each in pair.split(",")] for pair in stated.split()]]
        except ValueError:
            listed = None
    try:
        return checked_polygons(listed)
    except ValueError:
        raise BadInputError(
            f"{where}: is no {noun}; give a JSON file with a list of polygons, each a list of at "
            'least three [column, row], or one polygon as "U,V U,V U,V".'
        ) from None


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # many corners are too long a name
        return False


def checked_point(value: object) -> Point:
    """Return [column, row] as a point. Raises ValueError."""
    if not _is_point(value):
        raise ValueError("give a pixel as [column, row]")
    return _point(value)


def checked_points(value: object) -> tuple[Point, ...]:
    """Return a list of [column, row] as points. Raises ValueError."""
    if not isinstance(value, list | tuple) or not all(map(_is_point, value)):
        raise ValueError("give pixels as a list of [column, row]")
    if len(value) > MOST_POINTS:
        raise ValueError(f"give at most {MOST_POINTS} pixels")
    return tuple(map(_point, value))


def checked_polygons(value: object) -> tuple[Polygon, ...]:
    """Return a list of lists of [column, row] as polygons. Raises ValueError."""
    if not isinstance(value, list | tuple) or not all(
        isinstance(each, list | tuple) and len(each) >= 3 and all(map(_is_point, each))
        for each in value
    ):
        raise ValueError("give polygons, each a list of at least three [column, row]")
    return tuple(tuple(map(_point, polygon)) for polygon in value)


def checked_flag(value: object) -> bool:
    """Return true. Raises ValueError for anything else."""
    if value is not True:
        raise ValueError("give true, or leave it out")
    return True


def _is_point(value: object) -> TypeGuard[Sequence[float]]:
    return isinstance(value, list | tuple) and len(value) == 2 and all(map(_is_number, value))


def _is_number(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number of more than 308 digits
        return False


def _point(value: Sequence[float]) -> Point:
    u, v = value
    return float(u), float(v)
