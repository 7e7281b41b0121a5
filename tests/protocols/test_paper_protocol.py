"""The paper's protocol, number by number, planned and run."""

from collections import Counter

import pytest

from labrig.testing.fake_devices import LIMITS
from labrig.testing.fake_rig import FakeRig
from protocols import (
    Place,
    Purpose,
    ReadingKind,
    check_schedule,
    make_schedule,
    time_under_voltage_s,
)
from protocols.execution.events import Outcome, ReadingTaken, VoltageSet
from protocols.kinds.pulse_train import PulseTrain

POSITIONS_M = (0.0, 0.005, 0.010, 0.015, 0.020, 0.025, 0.030)
PLACES = [Place("long", POSITIONS_M), Place("short", POSITIONS_M)]


@pytest.fixture
def run():
    return make_schedule(PulseTrain(), PLACES).runs[0]


def test_a_session_is_fourteen_measurements_in_the_order_of_the_file():
    runs = make_schedule(PulseTrain(), PLACES).runs
    assert [r.position_m for r in runs] == list(POSITIONS_M) * 2
    assert [r.configuration for r in runs] == ["long"] * 7 + ["short"] * 7
    assert {r.purpose for r in runs} == {Purpose.MEASUREMENT}
    assert {(r.mounting, r.approach, r.moisten, r.load_N, r.via_m) for r in runs} == {
        (0, "up", True, None, None)
    }


def test_a_run_lasts_19_2_seconds_of_which_13_2_are_under_voltage(run):
    assert run.duration_s == 19.2
    assert time_under_voltage_s(run) == pytest.approx(13.2, abs=1e-9)


def test_ten_readings_at_0_V_are_followed_by_22_alternating_pulses(run):
    assert len(run.readings) == 32
    assert [r.voltage_V for r in run.readings] == [0.0] * 10 + [2.0, -2.0] * 11
    assert [s.voltage_V for s in run.steps] == [0.0] + [2.0, -2.0] * 11 + [0.0]
    assert [s.time_s for s in run.steps] == pytest.approx(
        [0.0, *(6.0 + 0.6 * i for i in range(23))]
    )


def test_the_first_two_pulses_are_recorded_but_discarded(run):
    kinds = [r.kind for r in run.readings]
    assert kinds == (
        [ReadingKind.ZERO] * 10 + [ReadingKind.DISCARDED] * 2 + [ReadingKind.KEPT] * 20
    )
    kept = Counter(r.voltage_V for r in run.readings if r.kind is ReadingKind.KEPT)
    assert kept == {2.0: 10, -2.0: 10}


def test_readings_are_taken_half_a_second_into_each_slot_of_0_6_s(run):
    times_s = [run.time_of(r) for r in run.readings]
    assert times_s == pytest.approx([0.6 * slot + 0.5 for slot in range(32)], abs=1e-9)
    assert {r.half_window_s for r in run.readings} == {0.1}


def test_the_paper_is_within_the_limits():
    check_schedule(make_schedule(PulseTrain(), PLACES), LIMITS)


def test_running_it_writes_these_voltages_at_these_times_and_takes_these_readings(run):
    rig = FakeRig()
    schedule = make_schedule(PulseTrain(), [Place("long", (0.0,))])
    assert rig.scheduler().run(schedule) is Outcome.COMPLETED
    written = rig.of_kind(VoltageSet)
    assert [w.write.sheet_V for w in written] == [s.voltage_V for s in run.steps]
    zero_s = written[0].due_s
    assert [w.due_s - zero_s for w in written] == pytest.approx([s.time_s for s in run.steps])
    readings = rig.of_kind(ReadingTaken)
    assert [r.planned for r in readings] == list(run.readings)
    assert all(r.valid for r in readings)
    for r in readings:
        assert r.values["drive_V"] == pytest.approx(r.planned.voltage_V, abs=1e-9)
        assert r.values["current_A"] == pytest.approx(1e-3 * r.planned.voltage_V, abs=1e-9)
        # The input's force is 1 mV per V, on a ramp of 10 uV/s: unbiased only in the centre.
        expected = 1e-3 * r.planned.voltage_V + 1e-5 * (r.sample_time_s - 100.0)
        assert r.values["force_N"] == pytest.approx(expected, abs=1e-12)
        assert abs(r.frame_offset_s) <= 0.02 + 1e-9
