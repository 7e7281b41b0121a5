"""The position of each curve against where it crosses the arc."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import mm
from model.measurements import Condition, Curve, Measurements, SheetGeometry

NEAR = 0.3  # of the way from one position to the other: a curve crosses the arc at the other one


@dataclass(frozen=True)
class ExchangedCurves(DataCheck):
    """The curves of two positions are each other's, and may be so with the forces."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        for low_m, high_m in _exchanged(measurements):
            yield from _changes(low_m, high_m)


def _changes(low_m: float, high_m: float) -> Iterator[Change]:
    """Yield the curves of two positions exchanged, and curves and forces."""
    low, high = mm(low_m), mm(high_m)
    yield Change(
        where="position_mm",
        apply=lambda m, _: _with_curves_exchanged(m, low_m, high_m),
        sentence=lambda names, _value, _sigma: (
            f"the curves of {names} at {low} and at {high} are each other's (position_mm in the"
            " table of curves); the forces are where they belong"
        ),
        values=(1.0,),
    )
    yield Change(
        where="position_mm",
        apply=lambda m, _: _with_positions_exchanged(m, low_m, high_m),
        sentence=lambda names, _value, _sigma: (
            f"forces and curves of {names} at {low} and at {high} are each other's (position_mm)"
        ),
        values=(1.0,),
    )


def _exchanged(measurements: Measurements) -> Iterator[tuple[float, float]]:
    """Yield pairs of positions whose curves cross the arc at each other's place."""
    found = defaultdict(list)
    for one in measurements.conditions:
        if one.position_m is not None and one.curve is not None:
            sheet = measurements.sheets[one.configuration]
            found[one.position_m].append(_crossing_m(one.curve, sheet))
    crossings_m = {at_m: float(np.median(some)) for at_m, some in found.items()}
    for (low_m, of_low_m), (high_m, of_high_m) in combinations(sorted(crossings_m.items()), 2):
        off_m = max(abs(of_low_m - high_m), abs(of_high_m - low_m))
        if off_m < NEAR * (high_m - low_m):
            yield low_m, high_m


def _crossing_m(curve: Curve, sheet: SheetGeometry) -> float:
    """Return where a curve crosses the arc, as a position on it; NaN where it does not."""
    beyond = np.flatnonzero(np.hypot(curve.x_m, curve.y_m) >= sheet.arc_radius_m)
    if not len(beyond):
        return np.nan
    at = beyond[0]
    angle = np.arctan2(curve.y_m[at], curve.x_m[at]) - sheet.arc_origin_rad
    return float(sheet.arc_radius_m * np.arctan2(np.sin(angle), np.cos(angle)))


def _with_curves_exchanged(measurements: Measurements, low_m: float, high_m: float) -> Measurements:
    curves = {(c.position_m, *_beside_position(c)): c.curve for c in measurements.conditions}
    other = {low_m: high_m, high_m: low_m}
    conditions = tuple(
        replace(c, curve=curves.get((other[c.position_m], *_beside_position(c)), c.curve))
        if c.position_m in other
        else c
        for c in measurements.conditions
    )
    return replace(measurements, conditions=conditions)


def _with_positions_exchanged(
    measurements: Measurements, low_m: float, high_m: float
) -> Measurements:
    other = {low_m: high_m, high_m: low_m}
    conditions = tuple(
        replace(c, position_m=other.get(c.position_m, c.position_m))
        if c.position_m is not None
        else c
        for c in measurements.conditions
    )
    return replace(measurements, conditions=conditions)


def _beside_position(one: Condition) -> tuple[object, ...]:
    return one.configuration, one.voltage_V, one.approach, one.tilt_rad


CHECK = ExchangedCurves(
    name="exchanged_curves",
    meaning="the position of each curve against where it crosses the arc",
    order=25,
)
