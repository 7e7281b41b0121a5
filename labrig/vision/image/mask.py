"""Masks: polygons of an image whose pixels are not used."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt

from labrig.config.base import parse_json, read_text
from labrig.errors import BadInputError
from labrig.vision.calibration.optics import Optics, Point

MaskArray = npt.NDArray[np.uint8]
Polygons = tuple[tuple[Point, ...], ...]
SUBPIXEL_BITS = 4


def polygon_mask(optics: Optics, shape: tuple[int, int], margin_px: float = 0.0) -> MaskArray:
    """Return (rows, columns) what is 1 inside of the polygons, or as near to them as the margin."""
    import cv2

    mask = np.zeros(shape, np.uint8)
    for polygon in optics.mask_px or ():
        corners = np.round(np.array(polygon) * 2**SUBPIXEL_BITS).astype(np.int32)
        cv2.fillPoly(mask, [corners], 1, cv2.LINE_8, SUBPIXEL_BITS)
        if margin_px > 0:
            thick = max(1, round(2 * margin_px))
            cv2.polylines(
                mask, [corners], isClosed=True, color=1, thickness=thick, shift=SUBPIXEL_BITS
            )
    return mask


def read_mask(stated: str) -> Polygons:
    """Return the polygons of a JSON file, or one written as "U,V U,V U,V".

    The file holds a list of polygons, or an object with that list as `mask_px`. Raises
    BadInputError.
    """
    path = Path(stated)
    if path.suffix.lower() == ".json" or path.is_file():
        data = parse_json(read_text(path), stated)
        listed = data.get("mask_px") if isinstance(data, dict) else data
        return polygons_from(listed, stated)
    try:
        corners = [[float(each) for each in pair.split(",")] for pair in stated.split()]
    except ValueError:
        corners = []
    return polygons_from([corners], f"--mask '{stated}'")


def polygons_from(listed: object, where: str) -> Polygons:
    """Return a list of lists of [column, row] as polygons. Raises BadInputError."""
    if not isinstance(listed, list) or not all(_is_polygon(each) for each in listed):
        raise BadInputError(
            f"{where}: is no mask; give a JSON file with a list of polygons, each a list of at "
            'least three [column, row], or one polygon as "U,V U,V U,V".'
        )
    return tuple(tuple((float(u), float(v)) for u, v in polygon) for polygon in listed)


def _is_polygon(value: object) -> bool:
    return (
        isinstance(value, list)
        and len(value) >= 3
        and all(isinstance(pair, list | tuple) and len(pair) == 2 for pair in value)
        and all(_is_number(each) for pair in value for each in pair)
    )


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
