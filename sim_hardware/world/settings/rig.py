"""The tables of a world.toml for the rig around the sheet."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Literal, Self, get_args

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from sim_hardware.world.along import bump
from sim_hardware.world.settings.base import Angle, ClosedSettings, NotNegative, Positive

FloatArray = npt.NDArray[np.float64]
Signal = Literal["drive", "force", "current", "readback"]
SIGNALS: tuple[Signal, ...] = get_args(Signal)
OutputTerminal = Annotated[str, Field(pattern=r"^([A-Za-z0-9_-]+/)?ao[0-9]+$")]
InputTerminal = Annotated[str, Field(pattern=r"^([A-Za-z0-9_-]+/)?ai[0-9]+$")]


class WiringSettings(ClosedSettings):
    """The boards' terminals to which amplifier, load cell and shunt are wired.

    `USB6211/ai0` is a terminal of that device; `ai0` is that terminal of any device.
    """

    drive: OutputTerminal
    """To the amplifier's input."""
    force: InputTerminal
    """From the load cell."""
    current: InputTerminal
    """From the shunt."""
    readback: InputTerminal
    """From the amplifier's output."""

    @model_validator(mode="after")
    def _one_signal_a_terminal(self) -> Self:
        inputs = [self.force.lower(), self.current.lower(), self.readback.lower()]
        if len(set(inputs)) < len(inputs):
            raise ValueError("force, current and readback need a terminal each")
        return self

    def signal_at(self, device: str, channel: str) -> Signal | None:
        """Return what is wired to a terminal; None: nothing."""
        ends = (f"{device}/{channel}".lower(), channel.lower())
        return next((s for s in SIGNALS if getattr(self, s).lower() in ends), None)

    def terminals(self, signal: Signal, devices: Iterable[str]) -> set[str]:
        """Return the terminals of these devices to which a signal is wired."""
        wired = str(getattr(self, signal))
        return {wired} if "/" in wired else {f"{device}/{wired}" for device in devices}


class ArcSettings(ClosedSettings):
    """The arc on which the load cell sits, about the clamp's end."""

    radius_mm: Positive
    origin_deg: Annotated[float, Field(ge=-180, le=180)]
    """Polar angle of position 0."""
    scale_error: Annotated[float, Field(ge=-0.2, le=0.2)]
    """Relative excess of the rolls' travel over the commanded one."""
    screw_mm: Annotated[float, Field(ge=-2, le=2)]
    """Amplitude of an error that comes again with every turn of the stage's screw."""
    screw_pitch_mm: Positive
    slip_mm: Annotated[float, Field(ge=-5, le=5)]
    """Excess of the rolls' position over the commanded one, from `slip_from_mm` on."""
    slip_from_mm: float

    def reached_m(self, position_m: float) -> float:
        """Return the rolls' position for a commanded one."""
        error_mm = self.screw_mm * math.sin(2 * math.pi * position_m * 1e3 / self.screw_pitch_mm)
        if position_m * 1e3 >= self.slip_from_mm - 1e-9:
            error_mm += self.slip_mm
        return position_m * (1 + self.scale_error) + error_mm * 1e-3


class ClampSettings(ClosedSettings):
    """The clamp that holds the sheet."""

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
    """Force of the surface tension of water between sheet and rolls."""
    meniscus_dries_s: NotNegative
    """Time under voltage in which it falls to 1/e; 0: it stays."""


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


class InterlockSettings(ClosedSettings):
    """An external one-shot and relay in the amplifier's supply."""

    line: str
    """The digital line whose edges keep the relay closed, such as port0/line0; none: no relay."""
    hold_s: Positive
    """After the last edge the relay opens."""


class CameraTriggerSettings(ClosedSettings):
    """What is wired to the camera's trigger input."""

    lines: list[str]
    """Digital lines, such as port0/line1 or EIO1: a rising edge of any begins an exposure."""


class CellSettings(ClosedSettings):
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
    resonance_hz: Annotated[float, Field(gt=0, le=1000)]
    """Of its own, with the rolls on it, in a moving world ..."""
    damping: Annotated[float, Field(gt=0, lt=1)]
    """... relative to the critical one."""
    travel_mm_per_s: Annotated[float, Field(gt=0, le=1000)]
    """Greatest speed with which the rolls go to another position, in a moving world."""
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
    """Pick-up of the voltage across the sheet, at +2 V."""
    cable_mN: float
    """Force of its cable 30 mm along the arc; it grows with the square of the position."""


class ViewSettings(ClosedSettings):
    """Errors of the image that its calibration does not know of."""

    scale_error: Annotated[float, Field(ge=-0.5, le=0.5)]
    """Lengths look relatively so much longer."""
    stretch: Annotated[float, Field(ge=-0.5, le=0.5)]
    """Lengths along x look relatively so much longer."""
    perspective_x: Annotated[float, Field(ge=-0.5, le=0.5)]
    """Lengths look relatively so much longer 50 mm along x: the camera is turned."""
    perspective_y: Annotated[float, Field(ge=-0.5, le=0.5)]
    """The same along y."""
    roll_rad: Annotated[float, Field(ge=-0.5, le=0.5)]
    """The camera is turned about its own axis: pictures are, counter-clockwise, at the clamp."""
    dent_mm: Annotated[float, Field(ge=-5, le=5)]
    """Shift along y of the image at one place ..."""
    dent_x_mm: float
    dent_y_mm: float
    dent_width_mm: Positive
    """... less and less within this distance of it."""

    @property
    def is_undistorted(self) -> bool:
        """Whether everything is seen where it is."""
        errors = (self.scale_error, self.stretch, self.perspective_x, self.perspective_y)
        return not any(errors) and self.dent_mm == 0 and self.roll_rad == 0

    def seen(self, points_m: FloatArray) -> FloatArray:
        """Return where points (n, 2) appear to be."""
        if self.is_undistorted:
            return points_m
        x, y = points_m.T
        grown = 1 + self.scale_error + (self.perspective_x * x + self.perspective_y * y) / 0.05
        away = np.hypot(x - self.dent_x_mm * 1e-3, y - self.dent_y_mm * 1e-3)
        dent_m = self.dent_mm * 1e-3 * bump(away, 0.0, self.dent_width_mm * 1e-3)
        x, y = x * grown * (1 + self.stretch), y * grown + dent_m
        cos, sin = np.cos(self.roll_rad), np.sin(self.roll_rad)
        return np.column_stack((x * cos - y * sin, x * sin + y * cos))
