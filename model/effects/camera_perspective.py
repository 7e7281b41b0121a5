"""The camera does not look squarely at the sheet's plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects.interface import Effect, EffectParameter, ImagePoints, Values
from model.measurements import FloatArray

OVER_M = 0.05  # a length of the sheet's plane, not of one sheet: all are seen by the same camera
# an eighth of half a turn apart: halfway between two, a fifth of it is left
DIRECTIONS_RAD = tuple((np.pi * np.arange(8) / 8.0).tolist())


@dataclass(frozen=True)
class CameraPerspective(Effect):
    """The scale changes linearly across the image; it is right at the clamp."""

    def curve(self, points: ImagePoints, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.curve`."""
        across = points.x_m * np.cos(p["direction_rad"]) + points.y_m * np.sin(p["direction_rad"])
        share = p["relative_error"] * across / OVER_M
        return share * points.x_m, share * points.y_m


EFFECT = CameraPerspective(
    name="camera_perspective",
    meaning=(
        "The camera is tilted against the sheet's plane, so that the scale grows across the"
        " picture: away from the clamp, or towards positive deflection."
    ),
    form="r seen = (1 + c u/50 mm) r, from the clamp, u = x or y; a projection with a small tilt",
    location="camera",
    signature=(
        "Curves that are drawn out more and more with the distance from the clamp, or more on one"
        " side than on the other; the forces are right."
    ),
    isolates="A target with a grid in view; the camera turned by a quarter.",
    source=(
        "Hartley and Zisserman 2004, Multiple View Geometry in Computer Vision, ch. 2; Zhang 2000,"
        " IEEE Trans. Pattern Anal. Mach. Intell. 22, 1330"
    ),
    parameters=(
        EffectParameter(
            name="relative_error",
            meaning="change of scale over 50 mm",
            unit="",
            prior_scale=0.01,
            low=-0.5,
            high=0.5,
            scales_as="1/m",
        ),
        EffectParameter(
            name="direction_rad",
            meaning="in which the scale grows: 0 along x, pi/2 along y",
            unit="rad",
            prior_scale=0.0,
            low=-np.pi,
            high=np.pi,
            starting_values=DIRECTIONS_RAD,
        ),
    ),
    form_error_along=("place",),
    of_the_rig=True,
    moves_along_sheet=True,
)
