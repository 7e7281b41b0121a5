"""A controller at work: it is timed, clamped, recorded, and ends at 0 V whatever fails."""

import itertools
import math

import numpy as np
import pytest

from drivers.interfaces import DeviceError, OverloadError, SignalBlock
from labrig.testing.fake_rig import FakeRig, short_schedule
from protocols import EventBus, FinishReason, LoopTiming, ScheduleError, StopLevel, check_schedule
from protocols.execution.events import (
    Controlled,
    Outcome,
    OutputChanged,
    OutputState,
    SessionStopped,
    SignalsArrived,
    VoltageSet,
)
from protocols.execution.runs.control_loop import FRESH_PERIODS
from protocols.planning.controlled import controlled
from protocols.planning.limits import SafetyLimits, time_under_voltage_s
from protocols.planning.schedule import ForceStep
from tests.protocols.controlled_run import (
    DURATION_S,
    RATE_HZ,
    REFERENCE,
    STEP_N,
    controlled_schedule,
    integrator,
    run_controlled,
)

PERIOD_S = 1 / RATE_HZ
COARSE = LoopTiming(service_s=0.1, starved_s=1.0)


def periods_of(rig):
    return [period for event in rig.of_kind(Controlled) for period in event.periods]


def first_energised_s(rig):
    return next(time_s for time_s, volts in rig.output.writes if volts)


def at_energised(rig, act, after=30):
    """Call `act` at the so-manieth write of a voltage."""
    write, count = rig.output.write, itertools.count(1)

    def watched(sheet_V):
        if sheet_V and next(count) == after:
            act()
        return write(sheet_V)

    rig.output.write = watched


def check_ended_at_zero(rig, scheduler, finish, words, within_s=math.inf):
    assert scheduler.status.finish is finish
    assert words in scheduler.status.text
    assert rig.output.last_V == 0.0
    assert rig.guarded[-1] is False
    stopped = rig.events[-1]
    assert isinstance(stopped, SessionStopped)
    assert stopped.output is OutputState.SAFE
    energised = [time_s for time_s, volts in rig.output.writes if volts]
    zero_s = min(time_s for time_s, volts in rig.output.writes if time_s > energised[-1])
    assert zero_s - energised[-1] <= within_s


@pytest.mark.slow
def test_the_force_follows_its_reference_and_ends_at_0_V():
    rig, scheduler = run_controlled()
    assert scheduler.status.finish is FinishReason.COMPLETED
    periods = periods_of(rig)
    assert len(periods) == round(DURATION_S * RATE_HZ) - 1
    before, after = periods[round(1.5 * RATE_HZ) - 2], periods[round(3.0 * RATE_HZ) - 2]
    assert (before.reference_N, after.reference_N) == (0.0, STEP_N)
    assert abs(before.force_N) < 2e-6
    assert after.force_N == pytest.approx(STEP_N, rel=0.02)
    assert abs(periods[-1].force_N) < 2e-5
    assert rig.output.last_V == 0.0


@pytest.mark.slow
def test_a_period_is_written_at_its_time_and_recorded_with_what_it_knew():
    rig, _ = run_controlled()
    periods = periods_of(rig)
    due_s = np.array([period.due_s for period in periods])
    np.testing.assert_allclose(np.diff(due_s), PERIOD_S, atol=1e-9)
    late_s = np.array([period.write.before_s for period in periods]) - due_s
    assert 0.0 <= late_s.min() <= late_s.max() < 1e-3
    indexes = [period.sample_index for period in periods]
    assert np.all(np.diff(indexes) > 0)
    first = next(i for i, (_, volts) in enumerate(rig.output.writes) if volts)
    written = [volts for _, volts in rig.output.writes[first:]]
    recorded = [period.write.sheet_V for period in periods]
    skip = next(i for i, volts in enumerate(recorded) if volts)
    assert written[: len(recorded) - skip] == recorded[skip:]


@pytest.mark.slow
def test_forces_count_from_the_force_at_0_V_before_the_run():
    rig = FakeRig()
    rig.signals.spoil = lambda times_s, volts: np.add(volts[0], 5e-3, out=volts[0])
    rig, scheduler = run_controlled(rig)
    assert scheduler.status.finish is FinishReason.COMPLETED
    assert rig.of_kind(Controlled)[0].zero_N == pytest.approx(5e-3, rel=0.05)
    assert periods_of(rig)[250].force_N == pytest.approx(STEP_N, rel=0.02)


def test_the_voltage_is_kept_within_the_least_of_the_limits():
    reference = (ForceStep(0.0, 10e-3), ForceStep(0.4, 0.0))
    for limit_V, least_V in ((1.5, 1.5), (99.0, 2.5)):  # 2.5: of the rig
        rig, _ = run_controlled(law=integrator(limit_V=limit_V), reference=reference, duration_s=2)
        assert max(abs(volts) for _, volts in rig.output.writes) == least_V
        assert max(period.wanted_V for period in periods_of(rig)) > least_V


def test_nothing_winds_up_while_the_voltage_is_at_its_limit():
    reference = (ForceStep(0.0, 10e-3), ForceStep(0.4, 0.0))
    rig, scheduler = run_controlled(reference=reference, duration_s=2.0)
    assert scheduler.status.finish is FinishReason.COMPLETED
    back = periods_of(rig)[round(0.4 * RATE_HZ) - 1 :]
    assert back[1].write.sheet_V < 2.0


def test_a_voltage_at_its_limit_for_longer_than_stated_ends_the_run():
    rig, scheduler = run_controlled(reference=(ForceStep(0.0, 10e-3),))
    check_ended_at_zero(
        rig, scheduler, FinishReason.CONTROL_FAULT, "at its limit of ±2 V for 0.5 s"
    )
    limited = [period for period in periods_of(rig) if period.write.sheet_V == 2.0]
    assert len(limited) == pytest.approx(0.5 * RATE_HZ, abs=2)


def test_a_voltage_that_is_no_number_is_never_written():
    law = integrator(
        B=np.array([[1e200, -1e200]]), A=np.full((1, 1), 1e200), anti_windup=np.zeros(1)
    )
    rig, scheduler = run_controlled(law=law)
    assert scheduler.status.finish is FinishReason.CONTROL_FAULT
    assert "not a number" in scheduler.status.text
    assert all(abs(volts) <= 2.0 for _, volts in rig.output.writes)
    assert rig.output.last_V == 0.0


def test_a_period_that_begins_late_ends_the_run():
    rig = FakeRig()
    at_energised(rig, lambda: setattr(rig.signals, "cost_s", 2.5 * PERIOD_S))
    rig, scheduler = run_controlled(rig)
    check_ended_at_zero(rig, scheduler, FinishReason.CONTROL_FAULT, "ms late (limit 10 ms)", 0.06)


def test_a_write_that_takes_too_long_ends_the_run():
    rig = FakeRig()
    rig.output.stalls_s = {60: 2.2 * PERIOD_S}
    rig, scheduler = run_controlled(rig)
    check_ended_at_zero(rig, scheduler, FinishReason.CONTROL_FAULT, "ms late", 0.05)


def test_samples_that_stay_away_for_three_periods_end_the_run():
    rig = FakeRig()
    at_energised(rig, lambda: setattr(rig.signals, "silent", True))
    rig, scheduler = run_controlled(rig)
    check_ended_at_zero(rig, scheduler, FinishReason.DEVICE_FAULT, "within 3 periods (30 ms)", 0.02)
    began_s = next(p.due_s for p in periods_of(rig)[29:])
    assert rig.output.writes[-1][0] - began_s < (FRESH_PERIODS + 3) * PERIOD_S


def test_samples_that_are_late_by_less_are_used():
    rig = FakeRig()
    rig.signals.skip = set()
    read, turn = rig.signals.read_available, itertools.count()

    def every_second():
        rig.signals.silent = bool(next(turn) % 2)
        return read() if not rig.signals.silent else _nothing(rig)

    rig.signals.read_available = every_second
    rig, scheduler = run_controlled(rig)
    assert scheduler.status.finish is FinishReason.COMPLETED
    assert periods_of(rig)[290].force_N == pytest.approx(STEP_N, rel=0.05)


def _nothing(rig):
    return SignalBlock(rig.signals.sent, np.empty((3, 0)), rig.clock.now())


def test_no_sample_before_the_run_means_no_voltage_at_all():
    rig = FakeRig()
    rig.signals.silent = True
    rig, scheduler = run_controlled(rig)
    assert scheduler.status.finish is FinishReason.DEVICE_FAULT
    assert not scheduler.status.energised_once


@pytest.mark.parametrize(
    ("value", "words"),
    [(math.nan, "samples were lost"), (0.05, "the force input is at the end of its range")],
)
def test_a_force_that_means_nothing_ends_the_run(value, words):
    rig = FakeRig()

    def spoil():
        rig.signals.spoil = lambda times_s, volts: volts[0].fill(value)

    at_energised(rig, spoil)
    rig, scheduler = run_controlled(rig)
    check_ended_at_zero(rig, scheduler, FinishReason.DEVICE_FAULT, words, 2 * PERIOD_S)


def test_samples_that_are_lost_from_the_last_period_end_the_run():
    rig = FakeRig()
    read = rig.signals.read_available

    def cut():
        block = read()
        half = block.volts.shape[1] // 2
        return SignalBlock(block.first_index + half, block.volts[:, half:], block.read_s)

    at_energised(rig, lambda: setattr(rig.signals, "read_available", cut))
    rig, scheduler = run_controlled(rig)
    check_ended_at_zero(
        rig, scheduler, FinishReason.DEVICE_FAULT, "samples were lost", 2 * PERIOD_S
    )


@pytest.mark.slow
@pytest.mark.parametrize("device", ["output", "signals", "camera"])
def test_a_device_that_dies_at_any_moment_of_control_leaves_0_V(device):
    """Every seventh call fails once; the output's own zero is tried again by the safe shutdown."""
    healthy, _ = run_controlled(timing=COARSE, duration_s=2.0, reference=REFERENCE[:2])
    calls = healthy.faults[device].calls
    ends = {"output": 1, "signals": 2}.get(device, 3)
    for k in range(3, calls - ends, 7):
        rig = FakeRig()
        rig.faults[device].fail_at = lambda index, k=k: index == k
        rig, scheduler = run_controlled(rig, timing=COARSE, duration_s=2.0, reference=REFERENCE[:2])
        assert rig.output.last_V == 0.0
        assert scheduler.status.output is OutputState.SAFE
        assert scheduler.status.finish is FinishReason.DEVICE_FAULT
        assert f"call {k} " in scheduler.status.text


def test_0_V_is_written_before_anything_is_told_of_a_failure():
    rig, log = FakeRig(), []

    def emit(event):
        rig.events.append(event)
        log.append(rig.output.last_V)

    def fail():
        log.append("failed")
        raise DeviceError("the loop has lost its device")

    at_energised(rig, fail)
    run_controlled(rig, emit=emit)
    told = log[log.index("failed") + 1 :]
    assert told
    assert not any(told)


def test_a_recording_that_fails_during_control_leaves_0_V():
    rig, event_bus = FakeRig(), EventBus(threaded=False)

    def write(event):
        rig.events.append(event)
        if isinstance(event, Controlled) and event.periods[-1].due_s > rig.signals.start_s + 2.0:
            raise OSError("disk full")

    event_bus.add_required("the session file", write)
    rig, scheduler = run_controlled(rig, emit=event_bus.emit)
    check_ended_at_zero(rig, scheduler, FinishReason.RECORDING_FAULT, "disk full", 2 * PERIOD_S)


def test_a_guard_that_has_died_ends_the_run():
    rig = FakeRig()

    def beat():
        if rig.output.last_V and rig.clock.now() > first_energised_s(rig) + 1.0:
            raise BrokenPipeError("the guard is gone")

    rig, scheduler = run_controlled(rig, beat=beat)
    check_ended_at_zero(rig, scheduler, FinishReason.INTERNAL_ERROR, "the guard is gone", 0.02)


def test_an_overloaded_load_cell_ends_the_run():
    rig = FakeRig()

    def protect(volts):
        if volts.size and volts.max() > 0.7e-3:
            raise OverloadError("the load cell carries 130 mN: unload it at once")

    object.__setattr__(rig.devices, "protect", protect)
    rig, scheduler = run_controlled(rig)
    check_ended_at_zero(rig, scheduler, FinishReason.OVERLOAD, "130 mN", 2 * PERIOD_S)


@pytest.mark.parametrize("level", [StopLevel.NOW, StopLevel.AFTER_PULSE])
def test_a_stop_is_obeyed_within_a_period(level):
    rig = FakeRig()
    asked = []

    def ask():
        rig.stop.request(level, "stopped by Ctrl-C")
        asked.append(rig.clock.now())

    at_energised(rig, ask)
    rig, scheduler = run_controlled(rig)
    check_ended_at_zero(
        rig, scheduler, FinishReason.STOP_REQUESTED, "stopped by Ctrl-C", 2 * PERIOD_S
    )
    assert rig.events[-1].outcome is Outcome.ABORTED


def test_the_guard_hears_of_the_loop_often_enough_at_a_slow_rate_too():
    rig, scheduler = run_controlled(law=integrator(rate_hz=4.0), duration_s=8.0)
    assert scheduler.status.finish is FinishReason.COMPLETED
    on_s = [beat_s for beat_s in rig.beats_s if beat_s > first_energised_s(rig)]
    assert np.diff(on_s).max() <= 0.051


def test_what_was_not_told_yet_is_recorded_when_the_run_is_broken_off():
    rig = FakeRig()
    at_energised(rig, lambda: setattr(rig.signals, "silent", True))
    run_controlled(rig)
    last_V = [volts for _, volts in rig.output.writes if volts][-1]
    assert periods_of(rig)[-1].write.sheet_V == last_V
    assert isinstance(rig.events[-1], SessionStopped)


def test_a_controlled_run_needs_a_controller():
    rig = FakeRig()
    with pytest.raises(ScheduleError, match="there is no controller"):
        rig.scheduler().run(controlled_schedule())
    assert rig.output.writes == [(0.0, 0.0)]


def test_the_whole_time_of_control_counts_as_time_under_voltage():
    run = controlled_schedule(duration_s=31.0).runs[0]
    assert time_under_voltage_s(run) == 31.0
    with pytest.raises(ScheduleError, match="31 s under voltage is longer than the limit of 30 s"):
        check_schedule(controlled_schedule(duration_s=31.0), SafetyLimits(2.5, 30.0))


def test_a_place_that_the_protocol_does_not_measure_is_refused():
    with pytest.raises(ScheduleError, match="does not measure long at 5 mm"):
        controlled(short_schedule(0.0), "long", 0.005, REFERENCE, DURATION_S)


@pytest.mark.parametrize(
    ("reference", "words"),
    [
        ((ForceStep(0.0, math.nan),), "not a finite number"),
        ((ForceStep(0.0, 0.0), ForceStep(0.0, 1e-3)), "not in the order of time"),
        ((ForceStep(0.5, 0.0),), "does not begin at 0 s"),
    ],
)
def test_a_reference_that_makes_no_sense_is_refused(reference, words):
    with pytest.raises(ScheduleError, match=words):
        check_schedule(controlled_schedule(reference), SafetyLimits(2.5, 30.0))


@pytest.mark.slow
def test_samples_are_emitted_before_the_voltage_that_they_lead_to():
    rig, _ = run_controlled()
    blocks = {event.block.first_index: event.time_s for event in rig.of_kind(SignalsArrived)}
    assert len(blocks) > 300
    changes = [event.state for event in rig.of_kind(OutputChanged)]
    assert changes.count(OutputState.ENERGISED) >= 1
    assert len(rig.of_kind(VoltageSet)) == 2
