"""Leave out free shapes that still swing, before the search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.discrepancy.data_checks.kinds._data import quoted
from model.measurements import Condition, Measurements

USUAL_M = 3e-5  # scatter of a curve's end from picture to picture, where none is stated
TIMES = 8.0  # that it may be exceeded
LEAST_M = 2e-4


def without_swinging(measurements: Measurements) -> tuple[Measurements, tuple[str, ...]]:
    """Return measurements without free shapes that swing, and a sentence for what is left out.

    Pulses that take turns make the sheet swing alike each time, so that single pictures may agree
    where others do not: with one voltage all those under voltage go. A shape at 0 V is taken before
    the pulses, and stays unless it swings itself.
    """
    free = [c for c in measurements.conditions if c.position_m is None]
    driven = {c.configuration for c in free if c.voltage_V and moves_m(c)}
    at_zero = {c.configuration for c in free if not c.voltage_V and moves_m(c)}

    def swings(one: Condition) -> bool:
        names = driven if one.voltage_V else at_zero
        return one.position_m is None and one.configuration in names

    kept = tuple(c for c in measurements.conditions if not swings(c))
    if len(kept) == len(measurements.conditions):
        return measurements, ()
    told = [
        f"free shapes of {quoted(sorted(names))} {where} are left out: they still swing"
        for names, where in ((driven, "under voltage"), (at_zero, "at 0 V"))
        if names
    ]
    return replace(measurements, conditions=kept), tuple(told)


def moves_m(one: Condition) -> float:
    """Return the RMS distance of the ends about their line in time, m; 0: not unusual."""
    curves = [r.curve for r in one.readings if r.valid and r.curve is not None]
    if len(curves) < 2:
        return 0.0
    ends = np.array([[c.x_m[-1], c.y_m[-1]] for c in curves])
    apart = np.diff(ends, axis=0) / np.sqrt(2.0)  # what goes on evenly is no swing
    found = float(np.sqrt(np.mean(np.sum(apart**2, axis=1))))
    stated = [float(c.sigma_m[-1]) for c in curves if c.sigma_m is not None]
    usual = max(USUAL_M, float(np.mean(stated)) if stated else 0.0)
    return found if found > max(LEAST_M, TIMES * usual) else 0.0
