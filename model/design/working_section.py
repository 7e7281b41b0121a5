"""Forces of a sheet in a working section: the first five questions of the paper's section 5.

Every answer carries the uncertainty of the model's parameters through. The sixth, the sheet of
least area, is in `sizing.py`; linear models and control are in `linear_models.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.design.force_map import (
    ForceMap,
    force_map,
    known_voltages,
    reached,
    resized,
    section,
)
from model.design.propagation import propagate
from model.measurements import FloatArray, ModelError, in_volts
from model.parameter import Parameter
from model.sheet.sheet_model import SheetModel
from model.sheet.solution import sampled_s

LONGER = (1.25, 1.6, 2.0, 2.5)  # lengths that are tried, in radii of the arc


@dataclass(frozen=True, kw_only=True)
class StraightLine:
    """1: the best line F = at_zero_N + slope p through F(p) at one voltage."""

    voltage_V: float
    slope_N_per_m: Parameter
    at_zero_N: Parameter
    rms_error_N: Parameter
    range_N: float  # of F over the section

    @property
    def relative_error(self) -> float:
        """RMS error over the range of the force."""
        return self.rms_error_N.value / self.range_N


def best_line(
    model: SheetModel, configuration: str, low_m: float, high_m: float, voltage_V: float
) -> StraightLine:
    """1: the line with the smallest squared error over the section."""
    p, volts = section(low_m, high_m), known_voltages(model, configuration)
    if voltage_V not in volts:
        volts = np.array([voltage_V])
    column = int(np.flatnonzero(volts == voltage_V)[0])

    def question(changed: SheetModel) -> list[float]:
        found = reached(force_map(changed, configuration, p, volts), column)
        force = found.tangential_N[:, column]
        slope, start = np.polyfit(p, force, 1)
        return [slope, start, float(np.sqrt(np.mean((slope * p + start - force) ** 2)))]

    slope, start, error = propagate(model, configuration, question, ("N/m", "N", "N"))
    force = force_map(model, configuration, p, volts).tangential_N[:, column]
    return StraightLine(
        voltage_V=voltage_V,
        slope_N_per_m=slope,
        at_zero_N=start,
        rms_error_N=error,
        range_N=float(np.ptp(force)),
    )


@dataclass(frozen=True)
class ShapeDifference:
    """2: how far the shapes at opposite EIBMs are apart at most, and where."""

    distance_m: Parameter
    position_m: float
    s_m: float
    voltages_V: tuple[float, float]


def shape_difference(
    model: SheetModel, configuration: str, low_m: float, high_m: float
) -> ShapeDifference:
    """2: the largest distance between the shapes at the lowest and the highest voltage."""
    p = section(low_m, high_m, 31)
    volts = known_voltages(model, configuration)
    ends = (float(volts[0]), float(volts[-1]))

    def apart(changed: SheetModel) -> tuple[FloatArray, FloatArray]:
        found = reached(force_map(changed, configuration, p, ends))
        s = sampled_s(found.setups[0])
        shapes = found.solved.shapes(s)
        x, y = (a.reshape(len(p), 2, len(s)) for a in (shapes.x_m, shapes.y_m))
        return s, np.hypot(x[:, 0] - x[:, 1], y[:, 0] - y[:, 1])

    (distance,) = propagate(
        model, configuration, lambda changed: [float(np.max(apart(changed)[1]))], ("m",)
    )
    s, between = apart(model)
    i, j = np.unravel_index(int(np.argmax(between)), between.shape)
    return ShapeDifference(distance, float(p[i]), float(s[j]), ends)


@dataclass(frozen=True)
class Reach:
    """3: the shortest sheet (or sheet and elongation) that reaches the object everywhere."""

    length_m: Parameter  # from the clamp to the farthest contact
    position_m: float  # which asks for most
    voltage_V: float


def shortest_sheet(model: SheetModel, configuration: str, low_m: float, high_m: float) -> Reach:
    """3: up to where sheet or elongation touches, at any voltage of the model.

    A configuration with an elongation keeps its sheet, and the elongation is what is shortened.
    """
    p, volts = section(low_m, high_m), known_voltages(model, configuration)

    def contacts(changed: SheetModel) -> FloatArray:
        return _reaching(changed, configuration, p, volts).s_hat_m

    (length,) = propagate(
        model, configuration, lambda changed: [float(np.max(contacts(changed)))], ("m",)
    )
    s_hat = contacts(model)
    i, j = np.unravel_index(int(np.argmax(s_hat)), s_hat.shape)
    return Reach(length, float(p[i]), float(volts[j]))


def _reaching(
    model: SheetModel, configuration: str, position_m: FloatArray, voltage_V: FloatArray
) -> ForceMap:
    """Return the map of the first of ever longer sheets, or elongations, that reaches all of it.

    What lies beyond the contact changes nothing; but the longer the sheet is, the more it curls.
    """
    sheet = model.sheet(configuration).sheet
    for share in LONGER:
        longer_m = share * sheet.arc_radius_m
        lengths = (sheet.free_length_m, longer_m) if sheet.elongation_m else (longer_m, 0.0)
        longer = resized(model, configuration, *lengths)
        found = force_map(longer, configuration, position_m, voltage_V)
        if found.all_reachable():
            return found
    i, j = np.argwhere(~found.reachable)[0]
    raise ModelError(
        f"no length of this sheet reaches {position_m[i] * 1e3:.3g} mm at {in_volts(voltage_V[j])};"
        " make the section smaller"
    )


@dataclass(frozen=True)
class LargestForce:
    """4: a largest force, where and at which voltage."""

    force_N: Parameter
    position_m: float
    voltage_V: float


def largest_forces(
    model: SheetModel, configuration: str, low_m: float, high_m: float
) -> dict[str, LargestForce]:
    """4: along the arc's tangent and normal, each in both directions.

    Keys: `tangent +`, `tangent -`, `normal +` (outward), `normal -`. A direction in which no force
    can be applied has a force of the other sign.
    """
    p, volts = section(low_m, high_m), known_voltages(model, configuration)

    def values(found: ForceMap) -> list[FloatArray]:
        return [found.tangential_N, -found.tangential_N, found.normal_N, -found.normal_N]

    def question(changed: SheetModel) -> list[float]:
        found = reached(force_map(changed, configuration, p, volts))
        return [float(np.max(v)) for v in values(found)]

    sizes = propagate(model, configuration, question, ("N",) * 4)
    found = force_map(model, configuration, p, volts)
    names = ("tangent +", "tangent -", "normal +", "normal -")
    result = {}
    for name, size, value in zip(names, sizes, values(found), strict=True):
        i, j = np.unravel_index(int(np.argmax(value)), value.shape)
        result[name] = LargestForce(size, float(p[i]), float(volts[j]))
    return result


@dataclass(frozen=True)
class BothWays:
    """5: the largest magnitude that can be applied in both directions everywhere in the section."""

    force_N: Parameter  # negative: somewhere only one direction is possible
    position_m: float  # the place that limits it
    pushes: bool  # whether the positive direction limits it


def force_both_ways(model: SheetModel, configuration: str, low_m: float, high_m: float) -> BothWays:
    """5: smallest over the section of what is possible in the weaker direction."""
    p, volts = section(low_m, high_m), known_voltages(model, configuration)

    def possible(changed: SheetModel) -> FloatArray:
        force = reached(force_map(changed, configuration, p, volts)).tangential_N
        return np.stack([force.max(axis=1), -force.min(axis=1)])

    (size,) = propagate(
        model, configuration, lambda changed: [float(np.min(possible(changed)))], ("N",)
    )
    both = possible(model)
    i, j = np.unravel_index(int(np.argmin(both)), both.shape)
    return BothWays(size, float(p[j]), bool(i == 0))
