"""The camera does not look squarely at the sheet's plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects.interface import Effect, Knob, Points, Values
from model.measurements import FloatArray


@dataclass(frozen=True)
class CameraPerspective(Effect):
    """The scale changes linearly across the picture, 0 in the middle of the sheet's length."""

    def curve(self, points: Points, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.curve`."""
        along_x, along_y = np.cos(p["direction_rad"]), np.sin(p["direction_rad"])
        across = (points.x_m / points.scale_m - 0.5) * along_x
        across = across + points.y_m / points.scale_m * along_y
        return p["relative_error"] * across * points.x_m, p["relative_error"] * across * points.y_m


EFFECT = CameraPerspective(
    name="camera_perspective",
    meaning=(
        "The camera is tilted against the sheet's plane, so that the scale grows across the"
        " picture: away from the clamp, or towards positive deflection."
    ),
    form="r seen = (1 + c (x/l - 1/2)) r, or (1 + c y/l) r, from the clamp; for a small tilt",
    slot="camera",
    signature=(
        "Curves that are too large on one side of the picture and too small on the other; the"
        " forces are right."
    ),
    isolates="A target with a grid in view; the camera turned by a quarter.",
    source=(
        "Hartley and Zisserman 2004, Multiple View Geometry in Computer Vision, ch. 2; Zhang 2000,"
        " IEEE Trans. Pattern Anal. Mach. Intell. 22, 1330"
    ),
    knobs=(
        Knob("relative_error", "change of scale over the sheet's length", "", 0.01, -0.5, 0.5),
        Knob(
            "direction_rad", "in which the scale grows: 0 along x, pi/2 along y", "rad", 0.0,
            -np.pi, np.pi, tried=(0.0, 0.5 * np.pi),
        ),
    ),
    tolerance=("place",),
)  # fmt: skip
