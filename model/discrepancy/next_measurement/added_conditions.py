"""What each candidate measurement adds to a session: conditions as they would be, without data."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from model.identification.data.acquisition_times import ReadingTimes
from model.identification.data.data_vector import ConditionData, DataVector
from model.measurements import FloatArray, in_volts
from model.measurements.pulse_train import PULSE_S

LONGER = 3  # times as many pulses, in a long run


def _touching(one: DataVector) -> list[ConditionData]:
    """Every position and voltage once, however often it was measured: as a session would again."""
    found: dict[tuple[float, float], ConditionData] = {}
    for seen in one.seen:
        if not seen.free:
            found.setdefault((seen.position_m, seen.voltage_V), seen)
    return list(found.values())


def _again(
    seen: ConditionData,
    mounting: int,
    *,
    at_m: float | None = None,
    up: float = 1.0,
    tilt_rad: float = 0.0,
) -> ConditionData:
    """Return the same in another set-up, with a number that no session has."""
    at_m = seen.position_m if at_m is None else at_m
    key = (seen.configuration, at_m, mounting, 0, tilt_rad)
    clock = replace(seen.clock, position_m=at_m)
    return replace(seen, run=key, position_m=at_m, up=up, tilt_rad=tilt_rad, clock=clock)


def positions_m(one: DataVector) -> list[float]:
    """Return the measured positions on the arc, in rising order."""
    return sorted({s.position_m for s in _touching(one)})


def _set_anew(one: DataVector, mounting: int) -> tuple[ConditionData, ...]:
    """Return the first, the middle and the last position."""
    places = positions_m(one)
    chosen = {places[i] for i in (0, len(places) // 2, -1)} if places else set()
    return tuple(_again(s, mounting) for s in _touching(one) if s.position_m in chosen)


def remounted(one: DataVector) -> tuple[ConditionData, ...]:
    """Return three positions in a new set-up."""
    return _set_anew(one, 90)


def reversed_approach(one: DataVector) -> tuple[ConditionData, ...]:
    """Return all positions, approached from the other side."""
    return tuple(_again(s, 91, up=-1.0) for s in _touching(one))


def repeated(one: DataVector) -> tuple[ConditionData, ...]:
    """Return all positions again."""
    return tuple(_again(s, 92) for s in _touching(one))


def long_runs(one: DataVector) -> tuple[ConditionData, ...]:
    """Return three positions with `LONGER` times as many readings under voltage."""
    return tuple(_longer(s) if s.voltage_V else s for s in _set_anew(one, 99))


def _longer(seen: ConditionData) -> ConditionData:
    """Return the same pulses going on and on; before them nothing changes."""
    clock, count = seen.kept_clock, LONGER * len(seen.kept_N)

    def on(values: FloatArray, step: float) -> FloatArray:
        step = float(np.median(np.diff(values))) if len(values) > 1 else step
        return np.asarray(values[0] + step * np.arange(count))

    pulses = 2.0  # from one pulse of this voltage to the next
    seconds = pulses * PULSE_S
    longer = replace(
        clock.of(np.zeros(len(clock.voltage_V), dtype=bool)),
        voltage_V=np.full(count, clock.voltage_V[0]),
        pulse_s=np.full(count, clock.pulse_s[0]),
        session=np.full(count, float(np.mean(clock.session))),
        run_began=np.full(count, float(np.mean(clock.run_began))),
        overall=np.full(count, float(np.mean(clock.overall))),
        opposite=np.resize(clock.opposite, count),
        opposite_V=np.resize(np.asarray(clock.opposite_V), count),
        rise_s=np.full(count, np.broadcast_to(clock.rise_s, len(clock.voltage_V))[0]),
        pulse=on(clock.pulse, pulses),
        run_s=on(clock.run_s, seconds),
        wetted_s=on(clock.wetted_s, seconds),
        driven_s=on(clock.driven_s, seconds),
        worked_s=on(np.asarray(clock.worked_s), seconds),
        position_m=seen.position_m,
    )
    own = seen.own_curves[-len(seen.kept_N) :]
    curves = tuple(own[k % len(own)] for k in range(count)) if own else ()
    counts = np.ones(count, dtype=bool)
    return replace(seen, force_N=np.zeros(count), clock=longer, counts=counts, own_curves=curves)


def turned_over(one: DataVector) -> tuple[ConditionData, ...]:
    """Return all positions with the rig turned over."""
    return tuple(_again(s, 98, tilt_rad=np.pi) for s in _touching(one))


def half_voltage(one: DataVector) -> tuple[ConditionData, ...]:
    """Return half the voltage at every position; 0 V there, too."""
    return tuple(
        replace(
            _again(s, 93),
            voltage_V=0.5 * s.voltage_V,
            clock=replace(s.clock, voltage_V=0.5 * s.clock.voltage_V),
        )
        for s in _touching(one)
    )


def free_shapes(one: DataVector) -> tuple[ConditionData, ...]:
    """Six shapes without the load cell: twice at each voltage."""
    result = []
    for mounting in (94, 95):
        for volts in sorted({s.voltage_V for s in one.seen}):
            like = next((s for s in one.seen if s.voltage_V == volts and s.curve is not None), None)
            if like is None:
                continue
            clock = ReadingTimes(
                voltage_V=volts, zeros=0, rise_s=one.sheet.rise_time_s, worked_s=0.0
            ).of_no_reading(0.5)
            result.append(
                replace(
                    like,
                    name=f"{one.sheet.configuration}, free, {in_volts(volts)}",
                    run=(one.sheet.configuration, np.inf, mounting, 0, 0.0),
                    tilt_rad=0.0,
                    position_m=np.nan,
                    force_N=np.zeros(0),
                    clock=clock,
                    counts=np.zeros(0, dtype=bool),
                    own_curves=(),
                )
            )
    return tuple(result)


def between(one: DataVector) -> tuple[ConditionData, ...]:
    """Return positions half-way between those measured."""
    places = positions_m(one)
    middle = {a: 0.5 * (a + b) for a, b in pairwise(places)}
    return tuple(
        _again(s, 97, at_m=middle[s.position_m]) for s in _touching(one) if s.position_m in middle
    )


def random_order(one: DataVector) -> tuple[ConditionData, ...]:
    """All positions again, in an order that has nothing to do with their place on the arc."""
    random = np.random.default_rng(7)
    places = positions_m(one)
    at = dict(zip(places, random.permutation(len(places)) / max(len(places) - 1, 1), strict=True))
    result = []
    for s in _touching(one):
        share = np.full(len(s.force_N), at[s.position_m])
        clock = replace(s.clock, session=share, run_began=share)
        result.append(replace(_again(s, 96), clock=clock))
    return tuple(result)


def zeros_without_contact(one: DataVector) -> tuple[ConditionData, ...]:
    """Return all positions again, each after a reading of the load cell without contact."""
    return repeated(one) + tuple(
        _load_cell_alone(s, 70 + i)
        for i, s in enumerate(s for s in repeated(one) if s.voltage_V == 0.0)
    )


def _load_cell_alone(like: ConditionData, mounting: int) -> ConditionData:
    count = len(like.kept_N)
    return replace(
        like,
        name=f"{like.configuration}, without contact, 0 V",
        run=(like.configuration, np.inf, mounting, 0, 0.0),
        position_m=np.nan,
        force_N=np.zeros(count),
        clock=replace(like.kept_clock, position_m=np.nan),
        counts=np.ones(count, dtype=bool),
        curve=None,
        own_curves=(),
        zero=True,
    )
