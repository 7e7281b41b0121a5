"""Free shapes that still swing are no shapes at rest: they are left out, and told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model.measurements import Condition, FloatArray, Measurements, scale_of_measurements

USUAL_M = 3e-5  # scatter of a curve's end from picture to picture, where none is stated
TIMES = 8.0  # that it may be exceeded
LEAST_M = 2e-4
SURE = 4.0  # standard deviations at which a course of the pulses is one
FEWEST = 3  # set-ups that tell it
Place = tuple[str, float]  # configuration, voltage


def without_swinging(
    measurements: Measurements, *, where_touched: bool = False
) -> tuple[Measurements, tuple[str, ...]]:
    """Return measurements without free shapes that swing, and a sentence for what is left out.

    Pulses that take turns make the sheet swing alike each time, so that single pictures may agree
    where others do not: with one voltage all those under voltage go. A shape at 0 V is taken before
    the pulses, and stays unless it swings itself. `where_touched`: shapes stay where they are all
    that there is of a configuration.
    """
    moving = swings_m(measurements)
    if where_touched:
        touched = {c.configuration for c in measurements.conditions if c.position_m is not None}
        moving = {place: size for place, size in moving.items() if place[0] in touched}
    driven = {name for name, volts in moving if volts}
    at_zero = {name for name, volts in moving if not volts}

    def swings(one: Condition) -> bool:
        names = driven if one.voltage_V else at_zero
        return one.position_m is None and one.configuration in names

    kept = tuple(c for c in measurements.conditions if not swings(c))
    if len(kept) == len(measurements.conditions):
        return measurements, ()
    told = [
        f"free shapes of {_quoted(names)} {where} are left out: they still swing"
        for names, where in ((driven, "under voltage"), (at_zero, "at 0 V"))
        if names
    ]
    return replace(measurements, conditions=kept), tuple(told)


def swings_m(measurements: Measurements) -> dict[Place, float]:
    """Return how far the ends of free shapes swing, m, by place; only what is not usual.

    A transient of the first pulses moves the end from picture to picture, too. It is one of the
    EIBM, and the forces in contact have it: what they tell of each pulse is no swing.
    """
    found, scale = dict[Place, float](), scale_of_measurements(measurements).length
    for one in measurements.conditions:
        size = _moves_m(one, _ends_m(one), scale) if one.position_m is None else 0.0
        if size and one.voltage_V:
            size = min(size, _moves_m(one, _as_steady(measurements, one), scale))
        if size:
            place = one.configuration, one.voltage_V
            found[place] = max(size, found.get(place, 0.0))
    return found


def _as_steady(measurements: Measurements, one: Condition) -> FloatArray:
    """Return the ends of a condition's pictures less what the forces tell of each pulse."""
    ends, own = _ends_m(one), one.configuration
    course = _course(measurements, own, one.voltage_V)
    at_rest = [
        _ends_m(c) for c in measurements.conditions
        if c.position_m is None and c.configuration == own and not c.voltage_V
    ]  # fmt: skip
    if not sum(map(len, at_rest)) or len(course) < len(ends):
        return ends
    reach = ends[-1] - np.mean(np.concatenate(at_rest), axis=0)
    return np.asarray(ends - course[: len(ends), None] * reach)


def _ends_m(one: Condition) -> FloatArray:
    """Return where the ends of a condition's pictures are: (n, 2)."""
    curves = [r.curve for r in one.readings if r.valid and r.curve is not None]
    return np.array([[c.x_m[-1], c.y_m[-1]] for c in curves]).reshape(-1, 2)


def _moves_m(one: Condition, ends: FloatArray, scale: float) -> float:
    """Return the RMS distance of the ends about their line in time, m; 0: not unusual."""
    if len(ends) < 2:
        return 0.0
    apart = np.diff(ends, axis=0) / np.sqrt(2.0)  # what goes on evenly is no swing
    found = float(np.sqrt(np.mean(np.sum(apart**2, axis=1))))
    curves = [r.curve for r in one.readings if r.valid and r.curve is not None]
    stated = [float(c.sigma_m[-1]) for c in curves if c.sigma_m is not None]
    usual = max(USUAL_M * scale, float(np.mean(stated)) if stated else 0.0)
    return found if found > max(LEAST_M * scale, TIMES * usual) else 0.0


def _course(measurements: Measurements, configuration: str, voltage_V: float) -> FloatArray:
    """Return by which share the voltage does more in each pulse than in the kept ones.

    As all forces in contact have it together; 0 where that is within their noise. Empty: not known.
    """
    own = [
        c for c in measurements.conditions
        if c.configuration == configuration and c.position_m is not None
    ]  # fmt: skip
    at_zero = {c.position_m: list[float]() for c in own}
    for c in own:
        if not c.voltage_V:
            at_zero[c.position_m] += [r.force_N for r in c.used()]
    rows, reach = list[FloatArray](), list[float]()
    for c in own:
        kept, zero = [r.force_N for r in c.used()], at_zero[c.position_m]
        if c.voltage_V == voltage_V and kept and zero and all(r.valid for r in c.readings):
            rows.append(np.array([r.force_N for r in c.readings]) - np.mean(kept))
            reach.append(float(np.mean(kept) - np.mean(zero)))
    if len(rows) < FEWEST:
        return np.zeros(0)
    return _shares(rows, np.array(reach))


def _shares(rows: Sequence[FloatArray], reach: FloatArray) -> FloatArray:
    """Return the regression of each pulse's forces on what the voltage does, where it is sure."""
    table = np.stack([row[: min(map(len, rows))] for row in rows])
    size = max(float(reach @ reach), 1e-300)
    share = reach @ table / size
    left = table - reach[:, None] * share
    unsure = np.sqrt(np.sum(left**2, axis=0) / (len(rows) - 1) / size)
    return np.where(np.abs(share) > SURE * unsure, share, 0.0)


def _quoted(names: set[str]) -> str:
    return " and ".join(f"'{name}'" for name in sorted(names))
