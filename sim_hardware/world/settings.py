"""What a world is made of: the tables of a world.toml, checked.

There are no defaults here: the shipped world.toml is the default, and a user's file says only what
differs from it. Keys are in the units of their names; properties and methods are SI.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, model_validator

from sim_hardware.optics import OpticsSettings

FloatArray = npt.NDArray[np.float64]

FaultKind = Literal[
    "daq_refused",
    "daq_hung",
    "daq_read_hung",
    "daq_slow",
    "daq_write_refused",
    "daq_reserved",
    "daq_buffer_overflow",
    "output_stuck",
    "force_nan",
    "drive_nan",
    "current_saturated",
    "cell_unplugged",
    "cell_overloaded",
    "camera_late",
    "camera_dropped",
    "camera_frozen",
    "camera_black",
    "camera_wrong_size",
    "camera_gone",
    "serial_garbage",
    "serial_half_line",
    "serial_silent",
    "serial_unplugged",
    "clock_jump",
]
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Ratio = Annotated[float, Field(ge=0, le=1)]
Angle = Annotated[float, Field(ge=-1.5, le=1.5)]


class Closed(BaseModel):
    """A table in which an unknown key, or a value that is not a number, is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


class ArcSettings(Closed):
    """The arc on which the load cell sits, about the clamp's end."""

    radius_mm: Positive
    origin_deg: Annotated[float, Field(ge=-180, le=180)]
    """Polar angle of position 0."""


class SheetSettings(Closed):
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
    stiffness_change: Annotated[float, Field(gt=-0.9, le=5)]
    """Relative change of B from the clamp to the end of the free length, as sin^2."""
    stiffening: Annotated[float, Field(gt=-0.5, le=5)]
    """Relative change of B at large changes of curvature."""
    stiffening_knee_per_m: Positive
    """Change of curvature with half of it."""
    elongation_give: Ratio
    """B over the elongation's stiffness; 0: it is rigid."""

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
        return self.rest_curvature_per_m * _fall(s_m, self.rest_curvature_decay_mm)

    def relative_stiffness(self, s_m: FloatArray) -> FloatArray:
        """B(s) over that at the clamp."""
        part = np.sin(0.5 * math.pi * np.asarray(s_m) / self.free_length_m)
        return np.asarray(1 + self.stiffness_change * part**2)


class EibmSettings(Closed):
    """The electrically induced bending moment, and how it follows the voltage."""

    curvature_per_m: Annotated[float, Field(ge=-400, le=400)]
    """Me/B at the clamp, settled at +2 V."""
    decay_mm: NotNegative
    """Length over which Me falls to 1/e along the sheet; 0: it does not fall."""
    negative_ratio: Annotated[float, Field(ge=0, le=3)]
    """|Me(-2 V)| / |Me(+2 V)|."""
    saturation_V: Positive
    """Me grows with V as tanh(V / saturation_V)."""
    build_up_s: Positive
    """Time constant with which Me follows the voltage across the sheet."""
    relaxation: Ratio
    """Share of Me that is lost again under a voltage that stays."""
    relaxation_s: Positive
    """Time constant of that loss."""

    def along_sheet(self, s_m: FloatArray) -> FloatArray:
        """Me/B in 1/m, settled at +2 V."""
        return self.curvature_per_m * _fall(s_m, self.decay_mm)

    def settled(self, sheet_V: float) -> float:
        """Me at a voltage, relative to that at +2 V, when everything has come to rest."""
        share = math.tanh(sheet_V / self.saturation_V) / math.tanh(2.0 / self.saturation_V)
        return share if share >= 0 else share * self.negative_ratio


class WaterSettings(Closed):
    """Water in the sheet: uneven after a rest, less and less under voltage."""

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


class AmplifierSettings(Closed):
    """Between the board's output and the sheet."""

    gain: Annotated[float, Field(gt=0, le=1000)]
    offset_mV: Annotated[float, Field(ge=-100, le=100)]
    """At its input."""
    rail_V: Positive
    """Largest output, either sign."""
    lag_ms: Annotated[float, Field(gt=0, le=1000)]
    """Time constant of its output."""


class ElectricalSettings(Closed):
    """The sheet as a load of the amplifier."""

    rise_time_s: Positive
    """Time constant with which the voltage rises across the sheet."""
    capacitance_mF: NotNegative
    leak_ohm: Positive
    shunt_ohm: Positive
    """The current is measured across it."""
    current_noise_mV: NotNegative
    readback_noise_mV: NotNegative


class LoadCellSettings(Closed):
    """The load cell and its wiring."""

    sensitivity_V_per_N: float
    offset_uV: float
    capacity_mN: Positive
    noise_mN: NotNegative
    """White, of one sample."""
    drift_mN: NotNegative
    """Standard deviation of the slow wander of the zero."""
    drift_shortest_s: Positive
    drift_longest_s: Positive
    hum_mN: NotNegative
    """Amplitude of what the mains (50 Hz) leaves."""
    nonlinearity: Annotated[float, Field(ge=-0.1, le=0.1)]
    """Error at full capacity, relative to it; it grows with the square of the load."""
    hysteresis_mN: NotNegative
    """Half the height of the loop at full turn."""
    hysteresis_reach_mN: Positive
    """Half the change of load that makes a full turn."""
    misalignment_deg: Annotated[float, Field(ge=-45, le=45)]
    """Of its axis from the tangent of the arc, counter-clockwise."""
    compliance_mm_per_mN: NotNegative
    """The object gives way along the arc."""


class ClampSettings(Closed):
    """How the sheet is held."""

    tilt_rad: Angle
    compliance_mrad_per_Nmm: Annotated[float, Field(ge=0, le=1e5)]
    """Turn of the clamped end per moment of the load."""


class RollsSettings(Closed):
    """The two rolls of the load cell, between which the sheet runs."""

    friction: Annotated[float, Field(ge=0, le=0.5)]
    """Tangential over normal force; always against the way the sheet was last moved."""
    offset_mm: Annotated[float, Field(ge=-5, le=5)]
    """From the sheet's neutral curve to the point that moves on the arc, along its normal."""
    stick_from_mm: float
    """The sheet sticks at this position and beyond it."""
    stick_mN: NotNegative
    """Force that it takes to get it loose; 0: it never sticks."""
    meniscus_mN: float
    """What the surface tension of water between sheet and rolls adds to the force."""


class ScatterSettings(Closed):
    """Standard deviations from one set-up to the next."""

    eibm: Ratio
    stiffness: Ratio
    position_mm: NotNegative
    clamp_tilt_rad: NotNegative
    registration_mm: NotNegative
    """Of the clamp's end in the picture, in each direction."""


class ChainSettings(Closed):
    """The numerics."""

    link_mm: Annotated[float, Field(ge=0.02, le=1)]
    step_ms: Annotated[float, Field(ge=0.1, le=10)]
    """Of the time grid on which the sheet's state moves."""


class InterlockSettings(Closed):
    """An external one-shot and relay in the amplifier's supply."""

    line: str
    """The digital line whose edges keep the relay closed, such as port0/line0; none: no relay."""
    hold_s: Positive
    """After the last edge the relay opens."""


class FaultSettings(Closed):
    """Something that goes wrong for a while."""

    what: FaultKind
    from_s: NotNegative
    until_s: Positive | None = None
    """None: for good."""
    since: Literal["beginning", "first_voltage"] = "beginning"
    """Of the world's time, or when the board was first told of a voltage other than 0."""
    amount_s: Positive = 0.2
    """Of a delay, or a jump."""

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.until_s is not None and self.until_s <= self.from_s:
            raise ValueError(f"until_s = {self.until_s} must be later than from_s = {self.from_s}")
        return self


class WorldSettings(Closed):
    """A whole world."""

    seed: Annotated[int, Field(ge=0, lt=2**63)]
    arc: ArcSettings
    configurations: Annotated[dict[str, SheetSettings], Field(min_length=1)]
    eibm: EibmSettings
    water: WaterSettings
    amplifier: AmplifierSettings
    electrical: ElectricalSettings
    load_cell: LoadCellSettings
    clamp: ClampSettings
    rolls: RollsSettings
    gravity_N_per_m: float
    """Weight of sheet per length that acts in the picture's plane, along -y."""
    frame_delay_s: Annotated[float, Field(ge=0, le=1)]
    """The camera shows what was there so long ago."""
    scatter: ScatterSettings
    chain: ChainSettings
    camera: OpticsSettings
    interlock: InterlockSettings
    faults: list[FaultSettings]


def _fall(s_m: FloatArray, decay_mm: float) -> FloatArray:
    s_m = np.asarray(s_m, dtype=float)
    return np.exp(-s_m / (decay_mm * 1e-3)) if decay_mm > 0 else np.ones_like(s_m)
