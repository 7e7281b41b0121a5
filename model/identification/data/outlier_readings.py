"""Readings far from the others of their condition: left out of the mean, and told."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.identification.data.robust_line import off_line, robust_sd
from model.identification.data.run_key import run_key
from model.identification.reading_patterns.catalogue import not_outliers
from model.identification.reading_patterns.contract import ReadingsOfCondition
from model.measurements import (
    Condition,
    Measurements,
    Reading,
    in_volts,
    scale_of_measurements,
)

FEWEST = 5  # readings of a condition
SIGMA = 15.0  # of a reading's noise, beyond which it is none of its condition's
MOST_SHARE = 0.25  # of a condition's readings: more are no outliers
SAME_PLACE_SHARE = 0.3  # of the conditions: more at the same place of the order are a transient
LEAST_N = 1e-6
NAMED = 3  # conditions
WHY = "far from the other readings"


@dataclass(frozen=True)
class WithoutOutliers:
    """Measurements without readings that are far from the others."""

    measurements: Measurements
    readings: int  # left out
    places: tuple[str, ...]  # conditions, sessions where there are several, and readings

    def sentences(self) -> tuple[str, ...]:
        """Return what was left out, or nothing."""
        if not self.readings:
            return ()
        many, where = self.readings > 1, self.places
        more = f" and {len(where) - NAMED} more" if len(where) > NAMED else ""
        told = (
            f"{self.readings} reading{'s' * many} far from the others of their condition"
            f" {'are' if many else 'is'} left out ({'; '.join(where[:NAMED])}{more})"
        )
        return (told,)


def left_out_readings(measurements: Measurements) -> tuple[int, int]:
    """Return how many readings were left out so, and of how many."""
    left_out = sum(r.why == WHY for c in measurements.conditions for r in c.readings)
    return left_out, left_out + sum(len(_ordered(one)) for one in measurements.conditions)


def without_outliers(measurements: Measurements) -> WithoutOutliers:
    """Mark readings as not valid that are far from the others of their condition.

    They are compared with a robust line in time, so that a drift is none, and with the noise of
    their own condition and of all conditions: both must be exceeded. What many conditions have at
    the same place, as the first pulses may, is no outlier, nor what is a pattern in the readings.
    """
    noise_N = _noise_N(measurements)
    least_N = LEAST_N * scale_of_measurements(measurements).force
    wild = [_wild(one, noise_N, least_N) for one in measurements.conditions]
    asked = sum(len(_ordered(one)) >= FEWEST for one in measurements.conditions)
    times = Counter(place for own in wild for place in own)
    usual = {place for place, count in times.items() if count > max(2, SAME_PLACE_SHARE * asked)}
    alike = not_outliers(_readings_of(measurements.conditions))
    wild = [
        own - usual - set(np.flatnonzero(those).tolist())
        for own, those in zip(wild, alike, strict=True)
    ]
    if not any(wild):
        return WithoutOutliers(measurements, 0, ())
    sessions = max(one.session for one in measurements.conditions)
    pairs = list(zip(measurements.conditions, wild, strict=True))
    return WithoutOutliers(
        replace(measurements, conditions=tuple(_marked(one, own) for one, own in pairs)),
        sum(map(len, wild)),
        tuple(_place(one, own, of_several=sessions > 1) for one, own in pairs if own),
    )


def _readings_of(conditions: Sequence[Condition]) -> list[ReadingsOfCondition]:
    every = [np.array([r.force_N for r in _ordered(one)]) for one in conditions]
    pairs = list(zip(conditions, every, strict=True))
    rest_N = {
        run_key(one): float(np.mean(found))
        for one, found in pairs if one.voltage_V == 0.0 and len(found)
    }  # fmt: skip
    return [
        ReadingsOfCondition(
            force_N=found,
            by_eibm_N=(
                float(np.mean(found)) - rest_N.get(run_key(one), np.nan)
                if one.voltage_V and len(found) else 0.0
            ),
        )
        for one, found in pairs
    ]  # fmt: skip


def _marked(one: Condition, places: set[int]) -> Condition:
    """Return a condition in which the readings at these places of the order are not valid."""
    wild = {id(reading) for place, reading in enumerate(_ordered(one)) if place in places}
    readings = tuple(
        replace(r, valid=False, why=WHY, curve=None) if id(r) in wild else r for r in one.readings
    )
    return replace(one, readings=readings)


def _place(one: Condition, places: set[int], *, of_several: bool) -> str:
    where = "free" if one.position_m is None else f"{one.position_m * 1e3:g} mm"
    session = f", session {one.session}" if of_several else ""
    numbers = [str(_ordered(one)[place].index) for place in sorted(places)]
    readings = f"reading{'s' * (len(numbers) > 1)} {' and '.join(numbers)}"
    return f"{one.configuration}, {where}, {in_volts(one.voltage_V)}{session}, {readings}"


def _wild(one: Condition, noise_N: float, least_N: float) -> set[int]:
    """Return the places of far readings in the order of a condition's readings."""
    readings = _ordered(one)
    if len(readings) < FEWEST or not noise_N:
        return set()
    off = off_line(np.array([r.force_N for r in readings]))
    own_N = robust_sd(off)
    far = np.abs(off) > SIGMA * max(noise_N, own_N, least_N)
    return set() if far.sum() > MOST_SHARE * len(readings) else set(np.flatnonzero(far).tolist())


def _noise_N(measurements: Measurements) -> float:
    """Return the standard deviation of a reading, from all conditions; 0: not known."""
    every = [_ordered(one) for one in measurements.conditions]
    off = [off_line(np.array([r.force_N for r in one])) for one in every if len(one) >= FEWEST]
    return float(np.median([robust_sd(one) for one in off])) if off else 0.0


def _ordered(one: Condition) -> list[Reading]:
    """Return the readings of the mean in time order; none of a free shape."""
    found = [r for r in one.used() if np.isfinite(r.force_N)]
    return sorted(found, key=lambda r: r.index) if one.position_m is not None else []
