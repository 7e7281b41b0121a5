"""What a pulse begins from: the EIBM of the voltage before it, whatever the protocol."""

from __future__ import annotations

import numpy as np
import pytest

from model.identification.data.preceding_eibm import PrecedingEibm
from model.identification.data.run_key import run_key
from model.measurements import Condition, Reading

# N: half as much at half the voltage, less at negative ones
FORCES_N = {0.0: 1e-3, 2.0: 3e-3, -2.0: -0.6e-3, 1.0: 2e-3, -1.0: 0.2e-3, 0.5: 1.5e-3, 1.5: 2.5e-3}


def run_of(order_V: list[float], *, discarded: int = 0) -> list[Condition]:
    """Return a run of readings in this order; the first ones under voltage are not recorded."""
    readings = dict[float, list[Reading]]()
    left = discarded
    for index, volts in enumerate(order_V):
        left -= bool(volts and left)
        if volts and left:
            continue
        kind = "kept" if volts else "zero"
        one = Reading(index=index, kind=kind, force_N=FORCES_N[volts])
        readings.setdefault(volts, []).append(one)
    return [
        Condition(configuration="long", position_m=0.01, voltage_V=v, readings=tuple(each))
        for v, each in readings.items()
    ]


def before(conditions: list[Condition], volts: float) -> list[float]:
    """Return the EIBM before each reading of a voltage, over that of this voltage."""
    (one,) = (c for c in conditions if c.voltage_V == volts)
    found = PrecedingEibm.of(conditions)
    index = [r.index for r in one.readings]
    result: list[float] = found.eibm(found.voltages_V(run_key(one), volts, index), volts).tolist()
    return result


def test_pulses_of_two_polarities_begin_from_each_other():
    conditions = run_of([0.0, 0.0] + [2.0, -2.0] * 3)
    assert before(conditions, 2.0) == pytest.approx([0.0, -0.8, -0.8])
    assert before(conditions, -2.0) == pytest.approx([-1.25] * 3)


def test_pulses_of_several_sizes_begin_from_the_one_before():
    conditions = run_of([0.0] + [2.0, -2.0, 1.0, -1.0] * 2)
    assert before(conditions, 2.0) == pytest.approx([0.0, -0.4])
    assert before(conditions, -2.0) == pytest.approx([-1.25] * 2)
    assert before(conditions, 1.0) == pytest.approx([-1.6] * 2)
    assert before(conditions, -1.0) == pytest.approx([-1.25] * 2)


def test_stairs_begin_from_the_step_below():
    conditions = run_of([0.0, 0.5, 1.0, 1.5, 2.0, 1.5, 1.0, 0.5, 0.0])
    assert before(conditions, 0.5) == pytest.approx([0.0, 2.0])
    assert before(conditions, 1.5) == pytest.approx([2.0 / 3.0, 4.0 / 3.0])


def test_pulses_of_one_voltage_begin_from_rest():
    assert before(run_of([0.0, 2.0, 2.0, 2.0]), 2.0) == [0.0] * 3


def test_where_the_pulse_before_is_not_recorded_the_usual_one_counts():
    conditions = run_of([0.0] + [2.0, -2.0, 1.0, -1.0] * 3, discarded=3)
    assert before(conditions, 1.0) == pytest.approx([-1.6] * 3)
    lone = [c for c in conditions if c.voltage_V in {0.0, 2.0}]
    assert before(lone, 2.0) == [-1.0] * len(next(c for c in lone if c.voltage_V).readings)


def test_a_force_that_barely_moves_says_nothing_of_the_eibm():
    still = {**FORCES_N, -2.0: FORCES_N[0.0] - 1e-9}
    conditions = [
        Condition(
            configuration="long", position_m=0.01, voltage_V=v,
            readings=tuple(
                Reading(index=i, kind="kept" if v else "zero", force_N=still[v]) for i in index
            ),
        )
        for v, index in {0.0: [0], 2.0: [1, 3], -2.0: [2]}.items()
    ]  # fmt: skip
    assert before(conditions, 2.0) == pytest.approx([0.0, -1.0 / 3.0])
    assert np.all(np.isfinite(before(conditions, -2.0)))
