"""Nothing is touched before a schedule is known to be harmless."""

from dataclasses import replace

import pytest

from labrig.testing.fake_devices import LIMITS
from labrig.testing.fake_rig import FakeRig, short_schedule
from protocols import (
    Extras,
    Place,
    SafetyLimits,
    ScheduleError,
    check_schedule,
    make_schedule,
    positions_m,
)
from protocols.extras.load_cell_step import LoadCellStep
from protocols.kinds.pulse_train import PulseTrain
from protocols.planning.schedule import VoltageStep


def changed(**run_changes):
    schedule = short_schedule()
    return replace(schedule, runs=(replace(schedule.runs[0], **run_changes),))


def faults(schedule, limits=LIMITS):
    with pytest.raises(ScheduleError) as refused:
        check_schedule(schedule, limits)
    return str(refused.value)


def test_all_faults_are_listed_together_with_their_limits_and_runs():
    train = PulseTrain(voltages_V=(3.0, -3.0), readings_per_voltage=30)
    text = faults(make_schedule(train, [Place("long", (0.0, 0.005, 0.010))]))
    assert "run 1 (long at 0 mm) and 2 more: 3 V at the sheet is beyond the limit of ±2.5 V" in text
    assert "37.2 s under voltage is longer than the limit of 30 s" in text
    assert text.count("run 1 (long at 0 mm)") == 1  # what the same runs have is said together


def test_exactly_at_the_limits_is_allowed():
    schedule = make_schedule(PulseTrain(), [Place("long", (0.0,))])
    check_schedule(schedule, SafetyLimits(2.0, 13.2))


def test_positions_hold_the_approach_of_repeats_and_moves_within_a_run():
    extras = Extras(added=(LoadCellStep(to_mm=30.0),))
    schedule = make_schedule(PulseTrain(), [Place("long", (0.0, 0.005))], extras=extras)
    assert positions_m(schedule.runs) == pytest.approx([0.0, 0.003, 0.005, 0.03])
    assert positions_m(schedule.repeats) == pytest.approx([-0.002, 0.0, 0.003, 0.005])


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"steps": ()}, "it has no steps"),
        ({"steps": (VoltageStep(0.0, 1.0),), "readings": ()}, "leaves 1 V at the sheet"),
        ({"steps": (VoltageStep(0.1, 0.0),), "readings": ()}, "the first step is not at 0 s"),
        (
            {"steps": (VoltageStep(0.0, 1.0), VoltageStep(0.0, 0.0)), "readings": ()},
            "not in the order of time",
        ),
        ({"steps": (VoltageStep(0.0, float("nan")),), "readings": ()}, "not a finite number"),
        ({"duration_s": 1.0}, "it is over before its last step"),
        ({"position_m": float("inf")}, "its position is not a finite number"),
    ],
)
def test_a_schedule_that_makes_no_sense_is_refused(change, says):
    assert says in faults(changed(**change))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"step": 99}, "reading 0 belongs to step 99"),
        ({"index": 5}, "the readings are not numbered"),
        ({"delay_s": 0.05}, "reading 0 begins before its step"),
        ({"delay_s": 1.15}, "reading 0 is not over when its step is"),
        ({"voltage_V": 1.0}, "reading 0 says 1 V, its step 0 V"),
        ({"delay_s": float("nan")}, "reading 0 has a time that is not a finite number"),
    ],
)
def test_a_reading_that_makes_no_sense_is_refused(change, says):
    readings = short_schedule().runs[0].readings
    assert says in faults(changed(readings=(replace(readings[0], **change), *readings[1:])))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (
            {"delay_s": 0.01},
            "5 readings begin before their step (the first is reading 0, its step lasts 1.2 s)",
        ),
        (
            {"delay_s": 1.19},
            "5 readings are not over when their step is (the first is reading 0, its step lasts",
        ),
        ({"voltage_V": 9.0}, "5 readings say another voltage than their step (the first is"),
    ],
)
def test_what_many_readings_have_in_common_is_said_once(change, says):
    readings = short_schedule().runs[0].readings
    said = faults(changed(readings=tuple(replace(one, **change) for one in readings)))
    assert says in said
    assert said.count("reading 0") == 1


def test_an_empty_or_misnumbered_schedule_is_refused():
    schedule = short_schedule()
    assert "no runs" in faults(replace(schedule, runs=()))
    assert "not numbered" in faults(replace(schedule, runs=(replace(schedule.runs[0], index=1),)))
    assert "frame_rate_hz" in faults(replace(schedule, frame_rate_hz=0.0))


@pytest.mark.parametrize("limit_V", [1.9, float("nan")])
def test_a_schedule_beyond_the_limits_is_refused_before_any_device_is_touched(limit_V):
    rig = FakeRig()
    with pytest.raises(ScheduleError, match="beyond the limit"):
        rig.scheduler(limits=replace(LIMITS, sheet_voltage_V=limit_V)).run(short_schedule())
    assert sum(faults.calls for faults in rig.faults.values()) == 0
    assert not rig.events


def test_the_outputs_own_limit_counts_too():
    rig = FakeRig()
    rig.output.limit_V = 1.0
    with pytest.raises(ScheduleError, match="beyond the limit of ±1 V"):
        rig.scheduler().run(short_schedule())
    assert rig.faults["output"].calls == 0
