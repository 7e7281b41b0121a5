"""Conditions that a method was not given, and what is true or was measured of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from benchmarks.hidden_effects.unmeasured import TrueCondition
from benchmarks.worlds.contract import Design, World
from model.measurements import Condition, Measurements

BETWEEN = 0.5  # of the session's voltages
Place = tuple[str, float, float]  # configuration, position in m, voltage


def unmeasured(
    one: World, hidden: Mapping[str, float], seed: int, recorded: Design
) -> list[TrueCondition]:
    """Return ten conditions of each configuration: half-way between positions, some voltages.

    They are asked for in sessions as long as the recorded one, so that 'amid the session' is the
    same time. Those that cannot be reached are left out.
    """
    high, low = recorded.voltages_V
    full, half = list[Place](), list[Place]()
    for c, (name, positions) in enumerate(recorded.positions_m.items()):
        between = _between(positions)
        full += [(name, at_m, (high, low, 0.0)[(k + c) % 3]) for k, at_m in enumerate(between)]
        some = zip(between[c::2], ((high,), (low,), (high, low)), strict=False)
        half += [(name, at_m, BETWEEN * v) for at_m, volts in some for v in volts]
    result = []
    for share, wanted in ((1.0, full), (BETWEEN, half)):
        found = _measured(one, hidden, seed, _as_long(recorded, share))
        result += [_true(found[place]) for place in wanted if place in found]
    return result


def _as_long(recorded: Design, share: float) -> Design:
    """Return a session between the positions, as long as the recorded one, at some voltages."""
    # one position fewer lies between the others: the last one is measured again
    positions = {n: (*_between(p), *p[-1:]) for n, p in recorded.positions_m.items()}
    high, low = recorded.voltages_V
    return replace(
        recorded, positions_m=positions, voltages_V=(share * high, share * low), series=False
    )


def _between(positions_m: Sequence[float]) -> list[float]:
    return [0.5 * (a + b) for a, b in pairwise(positions_m)]


def _measured(
    one: World, hidden: Mapping[str, float], seed: int, design: Design
) -> dict[Place, Condition]:
    """Return what was reached, the first time that a position was set."""
    found: dict[Place, Condition] = {}
    for c in one.measure(design, hidden, seed, exact=True).conditions:
        if c.position_m is not None and c.curve is not None and c.used():
            found.setdefault((c.configuration, c.position_m, c.voltage_V), c)
    return found


def without(measurements: Measurements, place_m: float) -> Measurements:
    """Return a session without a position, in both configurations."""
    return replace(
        measurements,
        conditions=tuple(c for c in measurements.conditions if c.position_m != place_m),
        series=tuple(s for s in measurements.series if s.position_m != place_m),
    )


def left_out(
    one: World, hidden: Mapping[str, float], seed: int, recorded: Design, place_m: float
) -> list[TrueCondition]:
    """Return what is true at a position amid the session that was recorded.

    A prediction is one of that time. The session came to the position at another time, when what
    goes on in its course was smaller or larger.
    """
    exact = one.measure(replace(recorded, series=False), hidden, seed, exact=True)
    return list(_there(exact, place_m))


def _there(measurements: Measurements, place_m: float) -> Iterator[TrueCondition]:
    for c in measurements.conditions:
        if c.position_m == place_m and c.curve is not None and c.used():
            yield _true(c)


def _true(c: Condition) -> TrueCondition:
    assert c.position_m is not None
    assert c.curve is not None
    return TrueCondition(
        configuration=c.configuration, position_m=c.position_m, voltage_V=c.voltage_V,
        force_N=float(np.mean([r.force_N for r in c.used()])), s_m=c.curve.s_m,
        points_m=np.stack([c.curve.x_m, c.curve.y_m], axis=1),
    )  # fmt: skip
