"""Conditions that a method was not given, and what is true or was measured of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from benchmarks.hidden_effects.unmeasured import TrueCondition
from benchmarks.worlds.contract import Design, World
from model.measurements import Condition, Measurements

BETWEEN_V = 1.0


def unmeasured(one: World, hidden: Mapping[str, float], seed: int) -> list[TrueCondition]:
    """Return ten conditions of each configuration: half-way between positions, some voltages."""
    stated, wanted = Design(), dict[tuple[str, float], float]()
    between = {n: [0.5 * (a + b) for a, b in pairwise(p)] for n, p in stated.positions_m.items()}
    high, low = stated.voltages_V
    for c, (name, places) in enumerate(between.items()):
        for k, at_m in enumerate(places):
            wanted[name, at_m] = (high, low, 0.0)[(k + c) % 3]
    full = _measured(one, hidden, seed, between, (high, low))
    found = [_true(c) for c in full if wanted[c.configuration, _place(c)] == c.voltage_V]
    for c, (name, places) in enumerate(between.items()):
        some = {name: places[c::2]}
        half = list(_measured(one, hidden, seed, some, (BETWEEN_V, -BETWEEN_V)))
        driven = [x for x in half if x.voltage_V != 0.0]
        signs = dict(zip(some[name], ((1.0,), (-1.0,), (1.0, -1.0)), strict=True))
        found += [_true(x) for x in driven if np.sign(x.voltage_V) in signs[_place(x)]]
    return found


def _measured(
    one: World, hidden: Mapping[str, float], seed: int, places: Mapping[str, list[float]],
    voltages_V: tuple[float, float],
) -> tuple[Condition, ...]:  # fmt: skip
    positions = {name: tuple(p) for name, p in places.items()}
    design = replace(Design(), positions_m=positions, voltages_V=voltages_V, series=False)
    return one.measure(design, hidden, seed, exact=True).conditions


def _place(c: Condition) -> float:
    assert c.position_m is not None
    return c.position_m


def without(measurements: Measurements, place_m: float) -> Measurements:
    """Return a session without a position, in both configurations."""
    return replace(
        measurements,
        conditions=tuple(c for c in measurements.conditions if c.position_m != place_m),
        series=tuple(s for s in measurements.series if s.position_m != place_m),
    )


def left_out(measurements: Measurements, place_m: float) -> list[TrueCondition]:
    """Return what was measured at a position."""
    return list(_there(measurements, place_m))


def _there(measurements: Measurements, place_m: float) -> Iterator[TrueCondition]:
    for c in measurements.conditions:
        if c.position_m == place_m and c.curve is not None:
            yield _true(c)


def _true(c: Condition) -> TrueCondition:
    assert c.curve is not None
    return TrueCondition(
        configuration=c.configuration, position_m=_place(c), voltage_V=c.voltage_V,
        force_N=float(np.mean([r.force_N for r in c.used()])), s_m=c.curve.s_m,
        points_m=np.stack([c.curve.x_m, c.curve.y_m], axis=1),
    )  # fmt: skip
