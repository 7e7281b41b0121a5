"""What a world is made of: the tables of a world.toml, checked.

There are no defaults here: the shipped world.toml is the default, and a user's file says only what
differs from it. Keys are in the units of their names; properties and methods are SI.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from sim_hardware.optics import OpticsSettings
from sim_hardware.world.along import EibmForm, StiffnessForm, broken, fall, stiffness_rise
from sim_hardware.world.settings_base import Angle, ClosedSettings, NotNegative, Positive, Ratio
from sim_hardware.world.settings_rare import BumpOf, BumpSettings, CreepSettings, ViewSettings

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


class ArcSettings(ClosedSettings):
    """The arc on which the load cell sits, about the clamp's end."""

    radius_mm: Positive
    origin_deg: Annotated[float, Field(ge=-180, le=180)]
    """Polar angle of position 0."""
    scale_error: Annotated[float, Field(ge=-0.2, le=0.2)]
    """The rolls go relatively so much further than they are told."""
    screw_mm: Annotated[float, Field(ge=-2, le=2)]
    """Amplitude of an error that comes again with every turn of the stage's screw."""
    screw_pitch_mm: Positive
    slip_mm: Annotated[float, Field(ge=-5, le=5)]
    """From `slip_from_mm` on the rolls are so much further than they are told."""
    slip_from_mm: float

    def reached_m(self, position_m: float) -> float:
        """Where the rolls are when they are told to go to a position."""
        error_mm = self.screw_mm * math.sin(2 * math.pi * position_m * 1e3 / self.screw_pitch_mm)
        if position_m * 1e3 >= self.slip_from_mm - 1e-9:
            error_mm += self.slip_mm
        return position_m * (1 + self.scale_error) + error_mm * 1e-3


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
    """How it gets there: sine (as sin^2), line, step (in the middle)."""
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
    """How it falls: exp, cosh, line (to 0 there), root (1/sqrt(1 + s/decay))."""
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
    """How both go on: in proportion to that time, to its square root, or to an end."""
    drying_s: Positive
    """Time constant of `exp`."""
    spread_order: Literal[1, 2]
    """The unevenness goes away at a rate that goes with this power of it."""
    tiring_per_min: NotNegative
    """Relative loss of Me in a minute at 2 V that no wetting brings back."""


class AmplifierSettings(ClosedSettings):
    """Between the board's output and the sheet."""

    gain: Annotated[float, Field(gt=0, le=1000)]
    offset_mV: Annotated[float, Field(ge=-100, le=100)]
    """At its input."""
    rail_V: Positive
    """Largest output, either sign."""
    lag_ms: Annotated[float, Field(gt=0, le=1000)]
    """Time constant of its output."""


class ElectricalSettings(ClosedSettings):
    """The sheet as a load of the amplifier."""

    rise_time_s: Positive
    """Time constant with which the voltage rises across the sheet."""
    capacitance_mF: NotNegative
    leak_ohm: Positive
    shunt_ohm: Positive
    """The current is measured across it."""
    current_noise_mV: NotNegative
    readback_noise_mV: NotNegative


class LoadCellSettings(ClosedSettings):
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
    warming_mN: float
    """Change of its zero after it was switched on ..."""
    warming_s: Positive
    """... in this time (exp: its time constant)."""
    warming_form: Literal["line", "root", "exp"]
    beat_mN: NotNegative
    """Amplitude of a disturbance that comes again ..."""
    beat_s: Positive
    """... with this period."""
    pickup_mN: float
    """What the voltage across the sheet adds, at +2 V."""
    cable_mN: float
    """What its cable adds 30 mm along the arc; it goes with the square of the position."""


class ClampSettings(ClosedSettings):
    """How the sheet is held."""

    tilt_rad: Angle
    compliance_mrad_per_Nmm: Annotated[float, Field(ge=0, le=1e5)]
    """Turn of the clamped end per moment of the load."""


class RollsSettings(ClosedSettings):
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
    meniscus_dries_s: NotNegative
    """Time under voltage in which it falls to 1/e; 0: it stays."""


class ScatterSettings(ClosedSettings):
    """Standard deviations from one set-up to the next."""

    eibm: Ratio
    stiffness: Ratio
    position_mm: NotNegative
    clamp_tilt_rad: NotNegative
    registration_mm: NotNegative
    """Of the clamp's end in the picture, in each direction."""


class ChainSettings(ClosedSettings):
    """The numerics."""

    link_mm: Annotated[float, Field(ge=0.02, le=1)]
    step_ms: Annotated[float, Field(ge=0.1, le=10)]
    """Of the time grid on which the sheet's state moves."""


class InterlockSettings(ClosedSettings):
    """An external one-shot and relay in the amplifier's supply."""

    line: str
    """The digital line whose edges keep the relay closed, such as port0/line0; none: no relay."""
    hold_s: Positive
    """After the last edge the relay opens."""


class FaultSettings(ClosedSettings):
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


class WorldSettings(ClosedSettings):
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
    creep: CreepSettings
    view: ViewSettings
    bumps: list[BumpSettings]
    scatter: ScatterSettings
    chain: ChainSettings
    camera: OpticsSettings
    interlock: InterlockSettings
    faults: list[FaultSettings]

    def eibm_per_m(self, configuration: str, s_m: FloatArray) -> FloatArray:
        """Me/B along a sheet, settled at +2 V."""
        sheet = self.configurations[configuration]
        along = self.eibm.along_sheet(s_m, sheet.free_length_m)
        return sheet.eibm_ratio * along + self.bumped("eibm", configuration, s_m)

    def bumped(self, of: BumpOf, configuration: str, s_m: FloatArray) -> FloatArray:
        """What bumps add to a property of a sheet."""
        result = np.zeros_like(s_m)
        for each in self.bumps:
            if each.of == of and each.configuration in ("", configuration):
                result += each.along(s_m)
        return result
