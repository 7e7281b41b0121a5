"""A motion that begins with charged electrodes, as what was held before time 0 has left them."""

from __future__ import annotations

import numpy as np
import pytest

from model.dynamics import ContactSetup, HeldVoltage, Simulation, simulate, start
from model.dynamics.identification import RunPlan
from model.dynamics.identification.predicted_run import predict
from model.dynamics.motion import Resolution
from tests.model.dynamics.cases import R, driven, plain

HELD = HeldVoltage(np.array([-1e4, 0.2]), np.array([1.5, -1.5]))
ROLLS = ContactSetup(radius_m=R, position_m=0.005)
TIMES = np.arange(0.0, 0.4, 2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("setup", [None, ROLLS], ids=["free", "on the rolls"])
def test_what_was_held_for_long_is_where_a_long_motion_comes_to(setup):
    late = 40.0
    long = simulate(
        driven(), setup, HeldVoltage(np.array([0.0, late + 0.2]), HELD.voltage_V), TIMES + late
    )
    begun = simulate(driven(), setup, HELD, TIMES)
    assert begun.current_A == pytest.approx(long.current_A, abs=1e-8)
    assert begun.force_N == pytest.approx(long.force_N, abs=3e-7)
    assert begun.x_m == pytest.approx(long.x_m, abs=1e-6)
    assert begun.y_m == pytest.approx(long.y_m, abs=1e-6)


def test_an_instant_alone_has_what_it_has_as_the_first_of_several():
    drive = HeldVoltage(np.array([-100.0]), np.array([2.0]))
    alone = Simulation(driven(), None, drive).advance(drive, [0.0])
    several = Simulation(driven(), None, drive).advance(drive, [0.0, 1e-3])
    for name in ("drive_V", "sheet_V", "current_A"):
        assert getattr(alone, name)[0] == getattr(several, name)[0]
    assert alone.drive_V == 2.0


def test_an_instant_without_electrodes_has_its_voltage():
    drive = HeldVoltage(np.zeros(1), np.ones(1))
    assert Simulation(plain(), None, drive).advance(drive, [0.0]).drive_V == 1.0


def test_pulses_before_the_beginning_leave_their_charge():
    pulses = HeldVoltage(np.array([0.0, 0.6, 1.1]), np.array([2.0, 0.0, 1.0]))
    whole = simulate(driven(), ROLLS, pulses, TIMES + 1.0)
    later = simulate(driven(), ROLLS, HeldVoltage(pulses.time_s - 1.0, pulses.voltage_V), TIMES)
    assert later.current_A == pytest.approx(whole.current_A, abs=1e-9)


def test_the_current_alone_begins_with_the_same_charge():
    plan = RunPlan(drive=HELD, time_s=TIMES, force=False)
    moved = RunPlan(drive=HELD, time_s=TIMES, setup=ROLLS)
    alone, both = (predict(driven(), run, Resolution()).current_A for run in (plan, moved))
    assert alone == pytest.approx(both, abs=1e-9)


def test_nothing_held_before_is_a_discharged_sheet():
    one = Simulation(driven(), None, HeldVoltage(np.zeros(1), np.ones(1)))
    assert np.array_equal(one.state.q, one.body.rest)  # no moment bends it


def test_an_equilibrium_that_is_gone_on_from_is_the_one_found_alone():
    """One begun near the last, and one that is known, are not touched by the motions from them."""

    def begun(volts):
        return Simulation(driven(), ROLLS, HeldVoltage(HELD.time_s, np.array([volts, -volts])))

    start._RESTING.clear()
    alone = begun(1.502).state
    start._RESTING.clear()
    first = begun(1.5)
    kept = first.state.q.copy()
    first.advance(HELD, TIMES)
    assert begun(1.5).state.q == pytest.approx(kept, rel=1e-12, abs=1e-12)
    near = begun(1.502).state
    assert near.q == pytest.approx(alone.q, rel=1e-9, abs=1e-9)
    assert near.x == pytest.approx(alone.x, rel=1e-9)
