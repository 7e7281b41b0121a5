"""Helpers that several data checks share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from model.measurements import Condition, Curve, FloatArray, Measurements, SheetGeometry
from model.measurements.arc_length import arc_length_m


def with_sheets(
    measurements: Measurements, change: Callable[[SheetGeometry], SheetGeometry]
) -> Measurements:
    """Return the same of other sheets."""
    return replace(measurements, sheets={n: change(s) for n, s in measurements.sheets.items()})


def with_conditions(
    measurements: Measurements, change: Callable[[Condition], Condition]
) -> Measurements:
    """Return the same with each condition changed."""
    return replace(measurements, conditions=tuple(change(c) for c in measurements.conditions))


def with_positions(measurements: Measurements, change: Callable[[float], float]) -> Measurements:
    """Return the same at other positions on the arc."""

    def moved(one: Condition) -> Condition:
        return one if one.position_m is None else replace(one, position_m=change(one.position_m))

    return with_conditions(measurements, moved)


def with_forces(measurements: Measurements, change: Callable[[float], float]) -> Measurements:
    """Return the same with other forces."""

    def other(one: Condition) -> Condition:
        readings = tuple(replace(r, force_N=change(r.force_N)) for r in one.readings)
        return replace(one, readings=readings)

    return with_conditions(measurements, other)


def with_curves(measurements: Measurements, change: Callable[[Curve], Curve]) -> Measurements:
    """Return the same with other curves."""

    def other(one: Condition) -> Condition:
        return one if one.curve is None else replace(one, curve=change(one.curve))

    return with_conditions(measurements, other)


def positions_m(measurements: Measurements) -> list[float]:
    """Return the positions on the arc, ascending."""
    return sorted({c.position_m for c in measurements.conditions if c.position_m is not None})


def curves_of(measurements: Measurements) -> list[Curve]:
    """Return the curves of all conditions, of their mean images where there are such."""
    found = []
    for one in measurements.conditions:
        own = [one.curve] if one.curve is not None else [r.curve for r in one.readings if r.valid]
        found += [curve for curve in own if curve is not None and len(curve.s_m) > 3]
    return found


def lengths_m(curves: list[Curve]) -> FloatArray:
    """Return the length of each curve along its points."""
    return np.array([arc_length_m(c.x_m, c.y_m)[-1] for c in curves])


def quoted(names: list[str]) -> str:
    """Return names as English has them: 'a', 'b' and 'c'."""
    marked = [f"'{name}'" for name in names]
    return " and ".join(filter(None, [", ".join(marked[:-1]), *marked[-1:]]))


def mm(value_m: float, sigma_m: float = np.nan) -> str:
    """Return a length as people read it, with its uncertainty where that is known."""
    if not np.isfinite(sigma_m):
        return f"{1e3 * value_m:.0f} mm" if value_m >= 1.0 else f"{1e3 * value_m:.3g} mm"
    digits = int(np.clip(1 - np.floor(np.log10(max(1e3 * sigma_m, 1e-3))), 0, 2))
    return f"{1e3 * value_m:.{digits}f} ± {1e3 * sigma_m:.{digits}f} mm"
