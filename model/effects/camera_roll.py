"""The camera is turned about its own axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects.interface import Effect, EffectParameter, ImagePoints, Values
from model.measurements import FloatArray


@dataclass(frozen=True)
class CameraRoll(Effect):
    """All points turned about the clamp, by the same angle."""

    def curve(self, points: ImagePoints, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.curve`."""
        cos, sin = np.cos(p["angle_rad"]) - 1.0, np.sin(p["angle_rad"])
        return cos * points.x_m - sin * points.y_m, sin * points.x_m + cos * points.y_m


EFFECT = CameraRoll(
    name="camera_roll",
    meaning=(
        "The camera is turned about its own axis against the clamp, so that pictures are turned"
        " counter-clockwise where the angle is positive."
    ),
    form="r seen = r turned by c about the clamp",
    location="camera",
    signature=(
        "Curves that leave the clamp at an angle, the same at every voltage and position; the"
        " forces are right. A clamp that is turned, and positions that are wrong by the same angle"
        " along the arc, together look alike."
    ),
    isolates="A plumb line or a straight edge along the clamp's direction in view.",
    source="Hartley and Zisserman 2004, Multiple View Geometry in Computer Vision, ch. 6",
    parameters=(
        EffectParameter(
            name="angle_rad",
            meaning="from the true directions to those in the picture",
            unit="rad",
            prior_scale=0.02,
            low=-0.5,
            high=0.5,
            instrument_limit=0.25,
            beyond="a camera turned by {degrees} degrees would be seen",
        ),
    ),
    form_error_along=("place",),
    of_the_rig=True,
)
