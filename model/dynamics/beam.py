"""What moves: the sheet with its mass, loss, fluid, electrodes and elongation, in SI numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite

import numpy as np

from model.dynamics.fluid import VACUUM, FluidLoad
from model.dynamics.line import ElectrodeLine
from model.dynamics.material import Viscoelasticity
from model.measurements import FloatArray, ModelError
from model.mechanics.field import Field


@dataclass(frozen=True, kw_only=True)
class Elongation:
    """The rigid straight end of the sheet."""

    length_m: float
    mass_per_length_kg_per_m: float = 0.0
    end_mass_kg: float = 0.0
    fluid: FluidLoad = VACUUM

    def __post_init__(self) -> None:
        """Refuse negative lengths and masses."""
        for name, value, unit in (
            ("length", self.length_m, "m"),
            ("mass per length", self.mass_per_length_kg_per_m, "kg/m"),
            ("mass at the end", self.end_mass_kg, "kg"),
        ):
            if not 0.0 <= value < np.inf:
                raise ModelError(
                    f"the elongation's {name} must be zero or positive, not {value:g} {unit}"
                )


NO_ELONGATION = Elongation(length_m=0.0)


@dataclass(frozen=True, kw_only=True)
class DynamicBeam:
    """The sheet in time."""

    length_m: float
    mass_per_length_kg_per_m: float
    material: Viscoelasticity
    rest: Field  # k0
    fluid: FluidLoad = VACUUM
    elongation: Elongation = NO_ELONGATION
    electrodes: ElectrodeLine | None = None  # None: the drive is a moment
    # Me = moment_per_volt U, for U > 0 and U < 0
    moment_per_volt_Nm: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse what is no sheet."""
        if not 0.0 < self.length_m < np.inf:
            raise ModelError(
                f"the sheet's free length must be positive, not {self.length_m * 1e3:g} mm"
            )
        if not 0.0 < self.mass_per_length_kg_per_m < np.inf:
            raise ModelError(
                "the sheet's mass per length must be positive,"
                f" not {self.mass_per_length_kg_per_m:g} kg/m"
            )
        if self.rest.length_m != self.length_m:
            raise ModelError("the initial curvature must end where the sheet's free length ends")
        if not isfinite(self.rest.largest):
            raise ModelError("the sheet's initial curvature is not finite everywhere")
        if not all(isfinite(a) for a in self.moment_per_volt_Nm):
            raise ModelError("the moment per volt must be a finite number")

    def moment_of(self, U: FloatArray) -> FloatArray:
        """Return Me of the double layer's voltage."""
        up, down = self.moment_per_volt_Nm
        return np.asarray(np.where(U > 0.0, up, down) * U)


@dataclass(frozen=True, kw_only=True)
class ContactSetup:
    """The load cell's rolls on the arc around the clamp."""

    radius_m: float
    position_m: float | Callable[[FloatArray], FloatArray]  # along the arc; a function of time
    origin_rad: float = 0.0  # polar angle of position 0
    resonance_hz: float = np.inf  # of the load cell
    damping: float = 0.0  # its damping ratio

    def __post_init__(self) -> None:
        """Refuse what is no load cell."""
        if not 0.0 < self.radius_m < np.inf:
            raise ModelError(f"the arc's radius must be positive, not {self.radius_m * 1e3:g} mm")
        if not self.resonance_hz > 0.0 or not 0.0 <= self.damping < np.inf:
            raise ModelError(
                "the load cell's resonance must be positive and its damping zero or positive,"
                f" not {self.resonance_hz:g} Hz and {self.damping:g}"
            )

    def angles(self, time_s: FloatArray) -> FloatArray:
        """Return the polar angle beta of the rolls at each time."""
        at = self.position_m
        position = at(time_s) if callable(at) else np.full(len(time_s), float(at))
        angles = self.origin_rad + np.asarray(position, dtype=float) / self.radius_m
        if angles.shape != time_s.shape or not np.all(np.isfinite(angles)):
            raise ModelError("the load cell's position must be a finite number at each time")
        return np.asarray(angles)


@dataclass(frozen=True, kw_only=True)
class ClampTurn:
    """A prescribed direction psi of the clamp."""

    angle_rad: Callable[[FloatArray], FloatArray]
    rate_rad_per_s: Callable[[FloatArray], FloatArray]
    acceleration_rad_per_s2: Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class HeldVoltage:
    """Voltages of the source, each held from its time to the next; 0 V before the first.

    Times before 0 tell how the electrodes are charged when a motion begins.
    """

    time_s: FloatArray  # ascending
    voltage_V: FloatArray

    def __post_init__(self) -> None:
        """Refuse times that do not ascend, and what is not finite."""
        if len(self.time_s) != len(self.voltage_V) or not len(self.time_s):
            raise ModelError("a drive needs as many voltages as times, and at least one")
        if not (np.all(np.isfinite(self.time_s)) and np.all(np.isfinite(self.voltage_V))):
            raise ModelError("times and voltages of a drive must be finite numbers")
        if np.any(np.diff(self.time_s) <= 0.0):
            raise ModelError("the times of a drive must ascend")

    def at(self, time_s: FloatArray) -> FloatArray:
        """Return the voltage at each time, at an edge the new one."""
        place = np.searchsorted(self.time_s, time_s, side="right")
        return np.asarray(np.concatenate([[0.0], self.voltage_V])[place])


@dataclass(frozen=True)
class PrescribedMoment:
    """A bending moment Me(s, t), for which no voltage is needed."""

    moment_Nm: Callable[[FloatArray, FloatArray], FloatArray]  # of times (n, 1), places (1, m)
    edges_s: tuple[float, ...] = field(default=())  # times at which it has a kink

    def at(self, time_s: FloatArray, s_m: FloatArray) -> FloatArray:
        """Return Me, (n, m)."""
        values = self.moment_Nm(time_s[:, None], s_m[None])
        return np.broadcast_to(np.asarray(values, dtype=float), (len(time_s), len(s_m)))


UNDRIVEN = HeldVoltage(np.zeros(1), np.zeros(1))
