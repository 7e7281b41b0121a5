"""The tables of a world.toml for the sheet: what it is, and how it follows a voltage."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from sim_hardware.world.along import EibmForm, StiffnessForm, broken, bump, fall, stiffness_rise
from sim_hardware.world.settings.base import ClosedSettings, NotNegative, Positive, Ratio

FloatArray = npt.NDArray[np.float64]
BumpOf = Literal["rest_curvature", "eibm", "even_moment", "stiffness"]


class SheetSettings(ClosedSettings):
    """One configuration of the sheet."""

    free_length_mm: Positive
    elongation_mm: NotNegative
    width_mm: Positive
    thickness_mm: Positive
    youngs_modulus_MPa: Positive
    rest_curvature_per_m: Annotated[float, Field(ge=-200, le=200)]
    """At the clamp."""
    rest_curvature_decay_mm: NotNegative
    """Length over which it falls to 1/e along the sheet; 0: it does not fall."""
    rest_curvature_step_mm: NotNegative
    """It is a straight line between places so far apart; 0: it is smooth."""
    eibm_ratio: Annotated[float, Field(gt=0, le=20)]
    """Me/B over that of [eibm]."""
    stiffness_change: Annotated[float, Field(gt=-0.9, le=5)]
    """Relative change of B from the clamp to the end of the free length."""
    stiffness_form: StiffnessForm
    """Its form: sine (as sin^2), line, step (in the middle)."""
    stiffening: Annotated[float, Field(gt=-0.5, le=5)]
    """Relative change of B at large changes of curvature."""
    stiffening_knee_per_m: Positive
    """Change of curvature with half of it."""
    elongation_give: Ratio
    """B over the elongation's stiffness; 0: it is rigid."""
    elongation_joint_mm: NotNegative
    """The joint between sheet and elongation gives way like so much of the sheet."""
    meniscus_share: Annotated[float, Field(ge=0, le=1)]
    """Share of the rolls' meniscus that this configuration feels."""

    @property
    def stiffness_Nm2(self) -> float:
        """B = E w d^3 / 12."""
        width_m, thickness_m = self.width_mm * 1e-3, self.thickness_mm * 1e-3
        return self.youngs_modulus_MPa * 1e6 * width_m * thickness_m**3 / 12

    @property
    def free_length_m(self) -> float:
        """Of the part that can bend."""
        return self.free_length_mm * 1e-3

    @property
    def elongation_m(self) -> float:
        """Of the rigid part beyond it."""
        return self.elongation_mm * 1e-3

    def rest_curvature(self, s_m: FloatArray) -> FloatArray:
        """k0(s) in 1/m."""
        return self.rest_curvature_per_m * broken(
            lambda s: fall(s, "exp", self.rest_curvature_decay_mm * 1e-3, self.free_length_m),
            s_m,
            self.rest_curvature_step_mm * 1e-3,
        )

    def relative_stiffness(self, s_m: FloatArray) -> FloatArray:
        """B(s) over that at the clamp."""
        rise = stiffness_rise(s_m, self.stiffness_form, self.free_length_m)
        return np.asarray(1 + self.stiffness_change * rise)


class EibmSettings(ClosedSettings):
    """The electrically induced bending moment, and how it follows the voltage."""

    curvature_per_m: Annotated[float, Field(ge=-400, le=400)]
    """Me/B at the clamp, settled at +2 V."""
    decay_mm: NotNegative
    """Length over which Me falls to 1/e along the sheet; 0: it does not fall."""
    form: EibmForm
    """Form of the fall: exp, cosh, line (to 0 there), root (1/sqrt(1 + s/decay))."""
    negative_ratio: Annotated[float, Field(ge=0, le=3)]
    """|Me(-2 V)| / |Me(+2 V)|."""
    saturation_V: Positive
    """Me grows with V as tanh(V / saturation_V)."""
    build_up_s: Positive
    """Time constant with which Me follows the voltage across the sheet."""
    relaxation: Annotated[float, Field(ge=-1, le=1)]
    """Share of Me that is lost again under a voltage that stays; negative: that comes slowly."""
    relaxation_s: Positive
    """Time constant of that loss."""
    relaxation_spread: Annotated[float, Field(ge=1, le=10)]
    """A third each with this time constant, and one so many times shorter and longer."""
    breathing: Ratio
    """Amplitude, relative, of a wave that goes through Me ..."""
    breathing_s: Positive
    """... with this period of time under voltage."""

    def along_sheet(self, s_m: FloatArray, length_m: float = 0.05) -> FloatArray:
        """Me/B in 1/m, settled at +2 V, of a sheet so long."""
        return self.curvature_per_m * fall(s_m, self.form, self.decay_mm * 1e-3, length_m)

    def settled(self, sheet_V: float) -> float:
        """Me at a voltage, relative to that at +2 V, when everything has come to rest."""
        share = math.tanh(sheet_V / self.saturation_V) / math.tanh(2.0 / self.saturation_V)
        return share if share >= 0 else share * self.negative_ratio


class WaterSettings(ClosedSettings):
    """Water in the sheet: uneven after a rest, less and less under voltage."""

    fluid: Literal["none", "air", "water"]
    """What a moving sheet moves in."""
    first_pulse_deficit: Ratio
    """Share of Me that is missing while the water is unevenly distributed."""
    spread_s: Positive
    """Time constant with which a voltage distributes it."""
    return_s: Positive
    """Time constant with which a rest undoes that."""
    stiffening_per_min: NotNegative
    """Relative gain of B in a minute at 2 V, at first; bounded by a factor of 2.2."""
    weakening_per_min: NotNegative
    """Relative loss of Me in a minute at 2 V, at first."""
    drying_form: Literal["line", "root", "exp"]
    """Form of both: in proportion to that time, to its square root, or to an end."""
    drying_s: Positive
    """Time constant of `exp`."""
    spread_order: Literal[1, 2]
    """The unevenness goes away at a rate that goes with this power of it."""
    tiring_per_min: NotNegative
    """Relative loss of Me in a minute at 2 V that no wetting brings back."""


class CreepSettings(ClosedSettings):
    """Viscosity of the sheet: a strain that stays loses a share of its stress."""

    share: Annotated[float, Field(ge=0, le=0.5)]
    """Of the stiffness that a quick strain meets."""
    time_s: Positive
    """Time constant of that loss."""
    spread: Annotated[float, Field(ge=1, le=10)]
    """A third each with this time constant, and one so many times shorter and longer."""


class BumpSettings(ClosedSettings):
    """A place along the sheet where it is not like its neighbours."""

    of: BumpOf
    """The property: rest_curvature, eibm, even_moment (1/m, at 2 V), stiffness (relative)."""
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
        """Return the amount at s."""
        return self.amount * bump(s_m, self.at_mm * 1e-3, self.width_mm * 1e-3)
