"""The optics of the simulated camera: the table `[camera]` of a world."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from sim_hardware.optics.lens import FloatArray, distorted
from sim_hardware.optics.marker import MARKER_COLUMNS

Level = Annotated[float, Field(ge=0, le=255)]
Side = Annotated[int, Field(ge=16, le=8192)]
Pixel = tuple[float, float]


class _Closed(BaseModel):
    """A table in which an unknown key or a value that is not a number is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Lens(_Closed):
    """The lens by OpenCV's model."""

    camera_matrix: tuple[
        tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]
    ]
    distortion: Annotated[tuple[float, ...], Field(min_length=4, max_length=5)]
    """k1, k2, p1, p2 and, if given, k3."""

    def distort(self, points_px: FloatArray) -> FloatArray:
        """Return where the lens shows undistorted pixels (n, 2)."""
        return distorted(points_px, self.camera_matrix, self.distortion)


class Jaws(_Closed):
    """The clamp: a rectangle that hides the sheet left of the world's origin."""

    visible: bool = True
    level: Level = 85.0
    length_m: float = Field(default=5e-3, gt=0)
    """Along the sheet."""
    height_m: float = Field(default=10e-3, gt=0)
    """Across it, both jaws together."""
    angle_rad: float = 0.0
    """Counter-clockwise in the image."""


class Rolls(_Closed):
    """The two rolls of the load cell, seen along their axes, one on either side of the sheet."""

    visible: bool = True
    radius_m: float = Field(default=1.2e-3, gt=0)
    level: Level = 75.0
    rim_level: Level = 120.0
    """Of the bright rim, `rim_m` wide."""
    rim_m: float = Field(default=0.12e-3, ge=0)


class CameraNoise(_Closed):
    """Of one frame. At the default levels the signal-to-noise ratio is about 30."""

    electrons_per_level: float = Field(default=10.0, gt=0)
    """Sets the shot noise: variance = level / electrons_per_level."""
    read_levels: float = Field(default=4.0, ge=0)
    """Standard deviation of what does not depend on the light."""


class Light(_Closed):
    """The unevenness of the light."""

    vignetting: float = Field(default=0.10, ge=0, lt=1)
    """Loss in the corners."""
    gradient: Pixel = (0.04, -0.03)
    """Relative change of brightness across the image's width and height."""
    unevenness: float = Field(default=0.03, ge=0, lt=1)
    """Relative variation of brightness along the sheet's edge."""


class Spot(_Closed):
    """A reflection: a round bright spot with a Gaussian profile."""

    at_px: Pixel
    radius_px: float = Field(gt=0)
    level: float
    """Added to the image at its centre; may be negative."""


class FarFace(_Closed):
    """The sheet's face behind its lit edge, seen because the far edge looks smaller."""

    level: Level
    depth_m: float = Field(default=11e-3, gt=0)
    """The sheet's width."""
    distance_m: float = Field(default=0.47, gt=0)
    """From the camera to the near edge."""


class OpticsSettings(_Closed):
    """Geometry and looks. Lengths are in m in the sheet's plane, levels are grey levels 0-255.

    The default is a bright (lit) sheet edge before a dark background.
    """

    image_size: tuple[Side, Side] = (640, 480)
    """Columns, rows."""
    frame_rate_hz: float = Field(default=25.0, gt=0, le=2000)
    exposure_s: float = Field(default=5e-3, ge=0)
    """The shapes handed to the renderer are spread over it."""

    px_per_mm: float = Field(default=8.9, gt=0)
    origin_px: Pixel = (80.2, 340.7)
    """Undistorted pixel of the world's origin, the end of the clamp; integers are centres."""
    roll_rad: float = 0.0
    """Turn of the image, clockwise as seen in it."""
    lens: Lens | None = None

    background_level: Level = 40.0
    sheet_level: Level = 210.0
    sheet_thickness_m: float = Field(default=0.21e-3, gt=0)
    elongation_level: Level = 160.0
    elongation_thickness_m: float = Field(default=0.5e-3, gt=0)
    blur_px: float = Field(default=0.7, ge=0, le=20)
    """Standard deviation of the lens's point spread."""

    jaws: Jaws = Jaws()
    rolls: Rolls = Rolls()
    noise: CameraNoise = CameraNoise()
    light: Light = Light()
    spots: tuple[Spot, ...] = ()
    far_face: FarFace | None = None
    marker: bool = False
    """Write the frame number (and time, if given) as black and white blocks at the top left."""

    @model_validator(mode="after")
    def _check(self) -> OpticsSettings:
        if self.exposure_s > 1 / self.frame_rate_hz:
            raise ValueError("exposure_s is longer than the time between two frames")
        if self.sheet_level == self.background_level:
            raise ValueError("sheet_level equals background_level: the sheet would be invisible")
        if self.marker and self.image_size[0] < MARKER_COLUMNS:
            raise ValueError(f"marker needs image_size of {MARKER_COLUMNS} columns or more")
        return self

    @property
    def polarity(self) -> Literal["bright", "dark"]:
        """Whether the sheet is brighter or darker than the background."""
        return "bright" if self.sheet_level > self.background_level else "dark"

    def calibration(self) -> dict[str, Any]:
        """Return what a perfect calibration would find: the content of an optics.json."""
        origin = np.array([self.origin_px])
        clamp = (origin if self.lens is None else self.lens.distort(origin))[0]
        content: dict[str, Any] = {
            "image_size": list(self.image_size),
            "px_per_mm": self.px_per_mm,
            "px_per_mm_sigma": 0.0,
            "roll_rad": self.roll_rad,
            "origin_px": list(self.origin_px),
            "clamp_px": [float(clamp[0]), float(clamp[1])],
            "clamp_angle_rad": self.jaws.angle_rad,
            "polarity": self.polarity,
            "bits": 8,
        }
        if self.lens is not None:
            content["camera_matrix"] = [list(row) for row in self.lens.camera_matrix]
            content["distortion"] = [*self.lens.distortion]
        return content
