"""The tables of a world.toml for what few worlds have: bumps, creep, a picture that deceives."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from sim_hardware.world.along import bump
from sim_hardware.world.settings_base import ClosedSettings, Positive

FloatArray = npt.NDArray[np.float64]
BumpOf = Literal["rest_curvature", "eibm", "even_moment", "stiffness"]


class BumpSettings(ClosedSettings):
    """A place along the sheet where it is not like its neighbours."""

    of: BumpOf
    """What differs: rest_curvature and the moments in 1/m (these at 2 V), stiffness relative."""
    at_mm: Annotated[float, Field(ge=0)]
    width_mm: Positive
    """Standard deviation of the bell curve."""
    amount: Annotated[float, Field(ge=-400, le=400)]
    configuration: str = ""
    """None: all of them."""

    @model_validator(mode="after")
    def _leaves_something(self) -> Self:
        if self.of == "stiffness" and self.amount <= -1.0:
            raise ValueError(f"amount = {self.amount} of a stiffness must be above -1")
        return self

    def along(self, s_m: FloatArray) -> FloatArray:
        """What is added at s."""
        return self.amount * bump(s_m, self.at_mm * 1e-3, self.width_mm * 1e-3)


class CreepSettings(ClosedSettings):
    """Viscosity of the sheet: a strain that stays loses a share of its stress."""

    share: Annotated[float, Field(ge=0, le=0.5)]
    """Of the stiffness that a quick strain meets."""
    time_s: Positive
    """Time constant of that loss."""
    spread: Annotated[float, Field(ge=1, le=10)]
    """A third each with this time constant, and one so many times shorter and longer."""


class ViewSettings(ClosedSettings):
    """How the picture deceives whoever believes the calibration."""

    scale_error: Annotated[float, Field(ge=-0.5, le=0.5)]
    """Lengths look relatively so much longer."""
    stretch: Annotated[float, Field(ge=-0.5, le=0.5)]
    """Lengths along x look relatively so much longer."""
    perspective_x: Annotated[float, Field(ge=-0.5, le=0.5)]
    """Lengths look relatively so much longer 50 mm along x: the camera is turned."""
    perspective_y: Annotated[float, Field(ge=-0.5, le=0.5)]
    """The same along y."""
    dent_mm: Annotated[float, Field(ge=-5, le=5)]
    """What lies at one place looks shifted along y by this ..."""
    dent_x_mm: float
    dent_y_mm: float
    dent_width_mm: Positive
    """... less and less within this distance of it."""

    @property
    def honest(self) -> bool:
        """Whether everything is seen where it is."""
        errors = (self.scale_error, self.stretch, self.perspective_x, self.perspective_y)
        return not any(errors) and self.dent_mm == 0

    def seen(self, points_m: FloatArray) -> FloatArray:
        """Where points (n, 2) appear to be."""
        if self.honest:
            return points_m
        x, y = points_m.T
        grown = 1 + self.scale_error + (self.perspective_x * x + self.perspective_y * y) / 0.05
        away = np.hypot(x - self.dent_x_mm * 1e-3, y - self.dent_y_mm * 1e-3)
        dent_m = self.dent_mm * 1e-3 * bump(away, 0.0, self.dent_width_mm * 1e-3)
        return np.column_stack((x * grown * (1 + self.stretch), y * grown + dent_m))
