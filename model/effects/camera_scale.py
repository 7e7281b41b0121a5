"""The image's scale is wrong."""

from __future__ import annotations

from dataclasses import dataclass

from model.effects.interface import Effect, EffectParameter, ImagePoints, Values
from model.measurements import FloatArray


@dataclass(frozen=True)
class CameraScale(Effect):
    """All points farther from the clamp by the same share, or less so along one axis."""

    def curve(self, points: ImagePoints, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.curve`."""
        along_x, along_y = min(1.0, 1.0 - p["axis"]), min(1.0, 1.0 + p["axis"])
        error = p["relative_error"]
        return error * along_x * points.x_m, error * along_y * points.y_m


EFFECT = CameraScale(
    name="camera_scale",
    meaning="Lengths in the picture come out too long by a constant share.",
    form=(
        "r seen = (1 + c) r, from the clamp; or x alone, or y alone, or one longer and the"
        " other shorter (pixels that are not square)"
    ),
    location="camera",
    signature=(
        "Curves that are everywhere too large, the same share at every voltage and position; the"
        " forces are right, and the sheet's visible length is not."
    ),
    isolates="A target of known length in view; the visible end of the sheet.",
    source="Hartley and Zisserman 2004, Multiple View Geometry in Computer Vision, ch. 6",
    parameters=(
        EffectParameter(
            name="relative_error",
            meaning="length seen over true length, less 1",
            unit="",
            prior_scale=0.01,
            low=-0.5,
            high=0.5,
            instrument_limit=0.2,
            beyond="a scale wrong by a factor of 1 + {value} would be seen with a ruler",
        ),
        EffectParameter(
            name="axis",
            meaning="0: both alike; -1: x alone; 1: y alone; between: the other one less; 2: y too"
            " long, and x too short by the same share",
            unit="",
            prior_scale=0.0,
            low=-1.0,
            high=2.0,
            starting_values=(0.0, -1.0, -0.5, 0.5, 1.0, 2.0),
        ),
    ),
    form_error_along=("place",),
    of_the_rig=True,
    moves_along_sheet=True,
)
