"""What holds for every protocol."""

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from labrig.testing.fake_rig import FakeRig
from protocols import (
    Extras,
    Place,
    SafetyLimits,
    ScheduleError,
    check_schedule,
    describe,
    make_schedule,
    schedule_from_dict,
    schedule_to_dict,
    time_under_voltage_s,
    timeline,
)
from protocols.execution.events import Outcome, ReadingTaken, VoltageSet
from protocols.extras.chirp import Chirp
from protocols.extras.free_shapes import FreeShapes
from protocols.extras.load_cell_step import LoadCellStep
from protocols.extras.release import Release
from protocols.kinds.hold import Hold
from protocols.kinds.pulse_train import PulseTrain
from protocols.kinds.staircase import Staircase
from protocols.kinds.step_response import StepResponse

volts = st.floats(-2.5, 2.5).map(lambda v: round(v, 3))
counts = st.integers(0, 4)


@st.composite
def pulse_trains(draw):
    pulse_s = draw(st.floats(0.2, 1.5))
    half_window_s = draw(st.floats(0.01, pulse_s / 4))
    return {
        "voltages_V": tuple(draw(st.lists(volts, min_size=1, max_size=4, unique=True))),
        "zero_readings": draw(counts),
        "pulses_discarded": draw(counts),
        "readings_per_voltage": draw(st.integers(1, 3)),
        "pulse_s": pulse_s,
        "sample_at_s": draw(st.floats(half_window_s, pulse_s - half_window_s)),
        "half_window_s": half_window_s,
        "rest_s": draw(st.sampled_from([0.0, 0.3])),
    }


def made(kind, settings):
    try:
        return kind(**settings)
    except ScheduleError:
        return None


seconds = st.floats(0.3, 2.0)
every = st.floats(0.05, 0.25)
steps = st.builds(
    dict, voltage_V=volts, hold_s=seconds, sample_every_s=every, before_s=seconds, after_s=seconds
)
holds = st.builds(
    dict,
    voltage_V=volts,
    hold_s=seconds,
    relax_s=seconds,
    cycles=st.integers(1, 3),
    sample_every_s=every,
)
stairs = st.builds(dict, voltages_V=st.lists(volts, min_size=1, max_size=6).map(tuple))
protocols = st.one_of(
    pulse_trains().map(lambda s: made(PulseTrain, s)),
    steps.map(lambda s: made(StepResponse, s)),
    holds.map(lambda s: made(Hold, s)),
    stairs.map(lambda s: made(Staircase, s)),
).filter(lambda protocol: protocol is not None)
ADDED = (
    FreeShapes(settled_s=4.0),
    FreeShapes(moving=True),
    Release(voltages_V=(1.0, -2.0)),
    Chirp(duration_s=2.0, amplitude_V=1.0),
    LoadCellStep(),
)
extras = st.builds(
    Extras,
    random_order_seed=st.none() | st.integers(0, 5),
    remounts=st.integers(0, 2),
    no_touch_zero=st.booleans(),
    added=st.just(()) | st.just(ADDED),
    reversed_approach=st.booleans(),
    dead_weights_N=st.just(()) | st.just((0.01, 0.02)),
)
WIDE = SafetyLimits(2.5, 1e4)


@pytest.mark.slow
@given(protocols, extras)
def test_every_schedule_begins_at_0_s_returns_to_0_V_and_reads_inside_its_steps(protocol, extra):
    schedule = make_schedule(protocol, [Place("long", (0.0, 0.01))], extras=extra)
    check_schedule(schedule, WIDE)
    for run in schedule.runs:
        assert run.steps[0].time_s == 0.0
        assert run.steps[-1].voltage_V == 0.0
        ends_s = [s.time_s for s in run.steps[1:]] + [run.duration_s]
        for reading in run.readings:
            at_s = run.time_of(reading)
            assert at_s - reading.half_window_s >= run.steps[reading.step].time_s - 1e-8
            assert at_s + reading.half_window_s <= ends_s[reading.step] + 1e-8
        assert 0.0 <= time_under_voltage_s(run) <= run.duration_s + 1e-9


@pytest.mark.slow
@given(protocols, extras)
def test_every_schedule_survives_json(protocol, extra):
    schedule = make_schedule(protocol, [Place("long", (0.0, 0.01))], extras=extra)
    assert schedule_from_dict(json.loads(json.dumps(schedule_to_dict(schedule)))) == schedule


@pytest.mark.slow
@given(protocols, st.floats(0.0, 2.5), st.floats(0.0, 20.0))
def test_a_schedule_passes_the_check_exactly_when_it_is_within_the_limits(
    protocol, limit_V, limit_s
):
    schedule = make_schedule(protocol, [Place("long", (0.0,))])
    run = schedule.runs[0]
    within_V = max(abs(s.voltage_V) for s in run.steps) <= limit_V
    within_s = time_under_voltage_s(run) <= limit_s + 1e-9
    if within_V and within_s:
        check_schedule(schedule, SafetyLimits(limit_V, limit_s))
    else:
        with pytest.raises(ScheduleError):
            check_schedule(schedule, SafetyLimits(limit_V, limit_s))


@pytest.mark.slow
@given(protocols, extras)
def test_every_schedule_can_be_described_and_drawn(protocol, extra):
    schedule = make_schedule(protocol, [Place("long", (0.0, 0.01))], extras=extra)
    plan = describe(schedule)
    assert len(plan.rows) == len(schedule.runs)
    assert plan.estimate_s > plan.running_s
    assert plan.running_s == pytest.approx(sum(r.duration_s for r in schedule.runs))
    for run, row in zip(schedule.runs, plan.rows, strict=True):
        assert sum(row.readings.values()) == len(run.readings)
        line = timeline(run)
        assert len(line.time_s) == len(line.voltage_V)
        assert list(line.time_s) == sorted(line.time_s)
        assert line.voltage_V[0] == line.voltage_V[-1] == 0.0


@pytest.mark.slow
@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow], deadline=None)
@given(protocols)
def test_running_any_protocol_does_what_its_schedule_says(protocol):
    schedule = make_schedule(protocol, [Place("long", (0.0,))])
    rig = FakeRig()
    assert rig.scheduler(limits=WIDE).run(schedule) is Outcome.COMPLETED
    run = schedule.runs[0]
    assert [w.write.sheet_V for w in rig.of_kind(VoltageSet)] == [s.voltage_V for s in run.steps]
    readings = rig.of_kind(ReadingTaken)
    assert [r.planned for r in readings] == list(run.readings)
    assert all(r.valid for r in readings), [r.why for r in readings if not r.valid]
