"""Draw a calibration: the grid of the sheet's plane over the image it was made from."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.errors import BadInputError
from labrig.files import write_bytes
from labrig.vision.calibration.optics import Optics

GRID_MM = 10.0
_REACH_MM = 200.0
_STEP_MM = 1.0
_HEADER_BYTES = 33  # of a PNG: its signature and its first chunk, which states the size
_TEXT = b"tEXt" + b"Software\0labrig drawing"
_MARK = struct.pack(">I", len(_TEXT) - 4) + _TEXT + struct.pack(">I", zlib.crc32(_TEXT))


def write_drawing(path: Path, canvas: npt.NDArray[np.uint8]) -> None:
    """Write a PNG that `is_drawing` knows, so that no batch takes it for a photograph."""
    import cv2

    good, data = cv2.imencode(".png", canvas)
    if not good:
        raise BadInputError(f"{path}: a drawing of {canvas.shape} pixels cannot be made.")
    png = data.tobytes()
    write_bytes(path, png[:_HEADER_BYTES] + _MARK + png[_HEADER_BYTES:])


def is_drawing(path: Path) -> bool:
    """Return whether `write_drawing` made a file; False where it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(_HEADER_BYTES + len(_MARK)).endswith(_MARK)
    except OSError:
        return False


def drawing_beside(optics: Path) -> Path:
    """Return where the drawing of a calibration goes. Raise where a photograph is already."""
    place = optics.with_suffix(".png")
    if place.exists() and not is_drawing(place):
        raise BadInputError(f"{place}: this image would be overwritten; give -o another name.")
    return place


def write_calibration_image(path: Path, image: npt.NDArray[Any], optics: Optics) -> None:
    """Draw a line every 10 mm through the lens as it is, the world's axes, and the clamp's end.

    Where the lines run along the board's squares, scale, axes and distortion are right.
    """
    import cv2

    grey = image if image.ndim == 2 else image[..., :3].mean(axis=2)
    eight_bit = cv2.normalize(grey, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    canvas = cv2.cvtColor(eight_bit, cv2.COLOR_GRAY2BGR)
    for place_mm in np.arange(-_REACH_MM, _REACH_MM + 1, GRID_MM):
        along = np.arange(-_REACH_MM, _REACH_MM + 1, _STEP_MM)
        axis = place_mm == 0
        for points_mm in (
            np.column_stack([along, np.full_like(along, place_mm)]),
            np.column_stack([np.full_like(along, place_mm), along]),
        ):
            _line(canvas, optics.world_to_pixel(points_mm / 1000), axis=axis)
    u, v = (round(value) for value in optics.clamp_px)
    cv2.drawMarker(canvas, (u, v), (80, 80, 255), cv2.MARKER_CROSS, 24, 2)
    write_drawing(path, canvas)


def _line(canvas: npt.NDArray[np.uint8], pixels: npt.NDArray[np.float64], *, axis: bool) -> None:
    import cv2

    rows, columns = canvas.shape[:2]
    # Far outside the canvas a lens model means nothing and may fold back into it.
    near = (np.abs(pixels[:, 0] - columns / 2) < columns) & (np.abs(pixels[:, 1] - rows / 2) < rows)
    colour, width = ((80, 80, 255), 2) if axis else ((90, 220, 90), 1)
    for first, second, seen in zip(pixels[:-1], pixels[1:], near[:-1] & near[1:], strict=True):
        if seen:
            start, end = (tuple(int(x) for x in np.rint(16 * p)) for p in (first, second))
            cv2.line(canvas, start, end, colour, width, cv2.LINE_AA, 4)
