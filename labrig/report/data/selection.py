"""Questions that every figure and table asks of measurements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model import Condition, Measurements
from model.measurements import FloatArray


@dataclass(frozen=True)
class MeanForce:
    """The force of one condition: mean and standard deviation of the readings that count."""

    position_m: float
    mean_N: float
    deviation_N: float  # NaN: fewer than two readings
    readings: int


def configurations(measurements: Measurements) -> list[str]:
    """Those that something was measured of, in the order of sheet.toml."""
    measured = {condition.configuration for condition in measurements.conditions}
    known = [name for name in measurements.sheets if name in measured]
    return known + sorted(measured - set(known))


def conditions_of(measurements: Measurements, configuration: str) -> list[Condition]:
    """All conditions of a configuration, in the order of their voltages and positions."""
    found = [c for c in measurements.conditions if c.configuration == configuration]
    return sorted(found, key=lambda c: (c.voltage_V, c.position_m is None, c.position_m or 0.0))


def voltages(measurements: Measurements, configuration: str | None = None) -> list[float]:
    """Return the voltages at which something was measured, highest first, as figures list them."""
    found = {
        c.voltage_V
        for c in measurements.conditions
        if configuration is None or c.configuration == configuration
    }
    return sorted(found, reverse=True)


def positions_m(measurements: Measurements, configuration: str) -> list[float]:
    """Return the load cell's positions, ascending."""
    found = {
        c.position_m
        for c in measurements.conditions
        if c.configuration == configuration and c.position_m is not None
    }
    return sorted(found)


def mean_force(condition: Condition) -> MeanForce | None:
    """Of a condition; None where nothing touched the load cell or no reading counts."""
    if condition.position_m is None:
        return None
    force_N = np.array([r.force_N for r in condition.used() if np.isfinite(r.force_N)])
    if not len(force_N):
        return None
    deviation = float(np.std(force_N, ddof=1)) if len(force_N) > 1 else float("nan")
    return MeanForce(condition.position_m, float(np.mean(force_N)), deviation, len(force_N))


def mean_forces(
    measurements: Measurements, configuration: str, voltage_V: float
) -> list[MeanForce]:
    """Of all set-ups of a configuration at a voltage, by ascending position."""
    found = [
        mean_force(c)
        for c in conditions_of(measurements, configuration)
        if c.voltage_V == voltage_V
    ]
    return [force for force in found if force is not None]


def rest_position_m(measurements: Measurements, configuration: str) -> float | None:
    """Where the undriven sheet rests: the force at 0 V is zero there, between two positions."""
    forces = mean_forces(measurements, configuration, 0.0)
    p = np.array([force.position_m for force in forces])
    F = np.array([force.mean_N for force in forces])
    for i in np.flatnonzero(np.sign(F[:-1]) * np.sign(F[1:]) <= 0):
        if F[i] != F[i + 1]:
            return float(p[i] + (p[i + 1] - p[i]) * F[i] / (F[i] - F[i + 1]))
    return None


def force_at_N(
    measurements: Measurements, configuration: str, voltage_V: float, position_m: float
) -> float | None:
    """Return the mean force at a voltage, interpolated between the positions about a place."""
    forces = mean_forces(measurements, configuration, voltage_V)
    p = np.array([force.position_m for force in forces])
    if not len(p) or not p[0] <= position_m <= p[-1]:
        return None
    return float(np.interp(position_m, p, [force.mean_N for force in forces]))


@dataclass(frozen=True)
class MeanForceLine:
    """The straight line through the mean forces of one voltage."""

    slope_N_per_m: float
    deviation_share: float  # RMS distance from the line over the range of the forces


def force_line(
    measurements: Measurements, configuration: str, voltage_V: float
) -> MeanForceLine | None:
    """How straight F(p) is; None with fewer than three positions."""
    forces = mean_forces(measurements, configuration, voltage_V)
    if len({force.position_m for force in forces}) < 3:
        return None
    p: FloatArray = np.array([force.position_m for force in forces])
    F: FloatArray = np.array([force.mean_N for force in forces])
    slope, offset = np.polyfit(p, F, 1)
    away = np.sqrt(np.mean((F - slope * p - offset) ** 2))
    return MeanForceLine(float(slope), float(away / np.ptp(F)))


def place(position_m: float | None) -> str:
    """Return a position in mm."""
    return "free" if position_m is None else f"{1e3 * position_m:g} mm"
