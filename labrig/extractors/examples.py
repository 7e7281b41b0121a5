"""Small images of a strip of known shape, drawn with NumPy alone, to try an extractor on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision import Optics, StripGeometry

FloatArray = npt.NDArray[np.float64]

SIZE_PX = (200, 150)  # columns, rows
PX_PER_MM = 4.0
CLAMP_PX = (24.0, 75.0)
STRIP = StripGeometry(free_length_m=0.03, elongation_m=0.0, thickness_m=0.6e-3)
BACKGROUND, CONTRAST, NOISE = 90.0, 80.0, 2.0  # grey levels of 255
BLUR_PX = 0.8


@dataclass(frozen=True)
class Example:
    """An image, its optics, and the arc of a circle that the strip in it is."""

    name: str
    image: npt.NDArray[Any]
    optics: Optics
    curvature_per_m: float | None  # None: no strip is in it

    def distances_m(self, x_m: FloatArray, y_m: FloatArray) -> FloatArray:
        """Return the distances (n,) of points from the strip's middle line, endless at its end."""
        return np.asarray(_across(self.curvature_per_m or 0.0, x_m, y_m))


def examples() -> list[Example]:
    """Return the images: bright, dark and 16-bit strips, a turned camera, and two without one."""
    plain = _optics()
    empty = np.full(SIZE_PX[::-1], BACKGROUND)
    return [
        drawn_arc("a bright strip bent up", 18.0, plain),
        drawn_arc("a dark strip bent down", -25.0, plain, sign=-1.0),
        drawn_arc("a straight strip in 16 bits", 0.0, _optics(bits=16), depth=16),
        drawn_arc("a strip before a turned camera", 18.0, _optics(roll_rad=0.1)),
        Example(
            "an image without a strip", _noisy(np.full(SIZE_PX[::-1], BACKGROUND)), plain, None
        ),
        Example("a uniform image", empty.astype(np.uint8), plain, None),
    ]


def _optics(**changes: Any) -> Optics:
    known = {"px_per_mm": PX_PER_MM, "clamp_px": CLAMP_PX, "image_size": SIZE_PX}
    return Optics.model_validate({**known, **changes})


def drawn_arc(
    name: str, curvature_per_m: float, optics: Optics, *, sign: float = 1.0, depth: int = 8
) -> Example:
    """Return the image of a strip that is an arc, brighter or darker than what is behind it."""
    columns, rows = SIZE_PX
    u, v = np.meshgrid(np.arange(columns, dtype=float), np.arange(rows, dtype=float))
    plane = optics.pixel_to_world(np.column_stack([u.ravel(), v.ravel()]))
    x, y = plane.T.reshape(2, rows, columns)
    along = _along(curvature_per_m, x, y)
    half = STRIP.thickness_m / 2
    across = _across(curvature_per_m, x, y)
    blur = BLUR_PX / optics.px_per_m
    band = _step((across + half) / blur) - _step((across - half) / blur)
    band *= _step(along / blur) - _step((along - STRIP.length_m) / blur)
    image = _noisy(BACKGROUND + sign * CONTRAST * band, 257 if depth == 16 else 1)
    return Example(name, image, optics, curvature_per_m)


def _step(x: FloatArray) -> FloatArray:
    """Return a blurred edge, which rises from 0 to 1 where x passes 0."""
    return np.asarray(0.5 * (1 + np.tanh(0.85 * x)))


def _across(curvature: float, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the signed distance from the arc that leaves the origin along +x."""
    if curvature == 0.0:
        return y
    return (1 / abs(curvature) - np.hypot(x, y - 1 / curvature)) * math.copysign(1, curvature)


def _along(curvature: float, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the arc length of each point's foot on that arc."""
    if curvature == 0.0:
        return x
    return np.arctan2(x * curvature, 1 - y * curvature) / curvature


def _noisy(grey: FloatArray, levels: int = 1) -> npt.NDArray[Any]:
    """Return an image of `levels` steps a grey level, with a camera's noise."""
    noise = np.random.default_rng(5).normal(0, NOISE, grey.shape)
    kind = np.uint8 if levels == 1 else np.uint16
    return np.clip(np.rint((grey + noise) * levels), 0, np.iinfo(kind).max).astype(kind)
