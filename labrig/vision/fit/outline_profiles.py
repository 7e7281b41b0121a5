"""What an image shows beside a curve, along its normals, and how much it changes there."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.image.image import GreyImage
from labrig.vision.search.straightened import slopes

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
MapArray = npt.NDArray[np.float32]

UNIT_RATIO = 0.04  # step across, in widths
UNIT_MAX_PX = 0.5
BLUR_RATIO = 0.1  # of an edge, in widths
FINE_BLUR_RATIO = 0.04  # where sharp edges are looked for
BLUR_MIN_PX = 0.8
SHIFT_RATIO = 0.6  # how far beside the curve the strip is looked for
EDGE_ROOM_RATIO = 0.22  # how far from its place in a strip of the usual width an edge may be


def across_px(width_px: float) -> FloatArray:
    """Return places across a strip, to both sides of its middle, beyond its edges."""
    unit = min(UNIT_MAX_PX, UNIT_RATIO * width_px)
    reach = (0.5 + SHIFT_RATIO + EDGE_ROOM_RATIO) * width_px + 3 * BLUR_MIN_PX
    many = math.ceil(reach / unit)
    return np.asarray(np.arange(-many, many + 1) * unit)


def greys_beside(
    shape: CurveShape,
    images: Sequence[GreyImage],
    optics: Optics,
    across: FloatArray,
    taper: FloatArray | None = None,
) -> list[FloatArray]:
    """Return (nodes, places across) each channel to the left of a curve; NaN outside.

    `taper` (nodes,): by which the places lie nearer to the curve.
    """
    import cv2

    across = across[None] if taper is None else taper[:, None] * across
    u, v = _pixels_beside(shape, optics, across)
    # remap takes no more than this many rows or columns at once
    parts = range(0, len(u), 8192)
    return [
        np.concatenate(
            [
                cv2.remap(
                    image.grey,
                    u[first : first + 8192],
                    v[first : first + 8192],
                    cv2.INTER_LINEAR,
                    borderMode=cv2.BORDER_CONSTANT,
                    borderValue=float("nan"),
                )
                for first in parts
            ]
        ).astype(np.float64)
        for image in images
    ]


def _pixels_beside(
    shape: CurveShape, optics: Optics, across: FloatArray
) -> tuple[MapArray, MapArray]:
    """Return (nodes, places across) the columns and rows of places to the left of a curve.

    `across` (1 or nodes, places).
    """
    sin, cos = np.sin(shape.phi), np.cos(shape.phi)
    if optics.is_similarity:  # a step in the plane is the same in pixels everywhere
        middle = np.stack([shape.x, shape.y], axis=1)
        there = np.concatenate([middle, middle + np.stack([-sin, cos], axis=1)])
        on, left = np.split(optics.world_to_pixel(there / optics.px_per_m), 2)
        u, v = (a[:, None] + (b - a)[:, None] * across for a, b in zip(on.T, left.T, strict=True))
        return u.astype(np.float32), v.astype(np.float32)
    x, y = shape.x[:, None] - sin[:, None] * across, shape.y[:, None] + cos[:, None] * across
    uv = optics.world_to_pixel(np.stack([x.ravel(), y.ravel()], axis=1) / optics.px_per_m)
    u, v = uv.T.reshape(2, *x.shape)
    return np.asarray(u, dtype=np.float32), np.asarray(v, dtype=np.float32)


def edge_sizes(
    shape: CurveShape,
    images: Sequence[GreyImage],
    optics: Optics,
    width_px: float,
    many: int,
    *,
    blur_ratio: float = BLUR_RATIO,
    taper: FloatArray | None = None,
) -> FloatArray:
    """Return (blocks, places across) how much the image changes there, over noise and texture.

    Blocks are of `many` nodes. Of several channels it is the root of the sum of squares: an edge
    may show in any of them.
    """
    across = across_px(width_px)
    unit = float(across[1] - across[0])
    blur = max(BLUR_MIN_PX, blur_ratio * width_px)
    beside = np.abs(across) > (0.5 + 0.5 * SHIFT_RATIO) * width_px
    count = max(1, len(shape.x) // many)
    total = np.zeros((count, len(across)))
    greys = greys_beside(shape, images, optics, across, taper)
    for image, grey in zip(images, greys, strict=True):
        rows = grey[: count * many]
        with np.errstate(invalid="ignore"):
            profiles = rows.reshape(count, many, -1).mean(axis=1)
        slope = slopes(profiles, blur / unit)
        texture = float(np.median(np.abs(slope[:, beside]))) / 0.6745
        pixels = 1.5 * image.noise / math.sqrt(many * shape.basis.step_px * blur)
        total += (slope / max(texture, pixels)) ** 2
    return np.asarray(np.sqrt(total / len(images)))


def running_sum(values: FloatArray | BoolArray, half: int) -> FloatArray:
    """Return (n,) the sum over `half` values to each side; beyond the ends there is nothing.

    As many as there are values, however few: `numpy.convolve` has no fewer than the window.
    """
    padded = np.pad(np.asarray(values, dtype=np.float64), half)
    return np.convolve(padded, np.ones(2 * half + 1), mode="valid")


def running_middle(values: FloatArray, half: int) -> FloatArray:
    """Return (n,) the median over `half` values to each side."""
    half = min(half, len(values) - 1)
    padded = np.pad(values, half, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1)
    if np.isnan(padded).any():
        return np.asarray(np.median(windows, axis=1))
    # the same of an odd number, several times as fast
    return np.asarray(np.partition(windows, half, axis=1)[:, half])
