"""Ending a session early."""

import pytest

from labrig.testing.fake_rig import FakeRig, short_schedule
from protocols import FinishReason, Place, RunState, StopLevel, make_schedule
from protocols.execution.events import (
    Outcome,
    OutputState,
    ReadingTaken,
    RunStarted,
    RunStopped,
    SessionStopped,
    SignalsArrived,
    VoltageSet,
)
from protocols.kinds.pulse_train import PulseTrain

TRAIN = make_schedule(PulseTrain(), [Place("long", (0.0, 0.005))])


def stopped(level, at_s, schedule=TRAIN):
    """A session with a request so many s after the first run's time 0."""
    rig = FakeRig()

    def emit(event):
        rig.events.append(event)
        if isinstance(event, RunStarted) and event.run.index == 0:
            when = event.time_s + at_s
            rig.clock.at.append((when, lambda: rig.stop.request(level, "STOP was pressed")))

    scheduler = rig.scheduler(emit=emit)
    assert scheduler.run(schedule) is Outcome.ABORTED
    assert scheduler.status.finish is FinishReason.STOP_REQUESTED
    assert rig.output.last_V == 0.0
    last = rig.events[-1]
    assert isinstance(last, SessionStopped)
    assert (last.outcome, last.reason) == (Outcome.ABORTED, "STOP was pressed")
    assert last.output is OutputState.SAFE
    assert not rig.signals.running
    assert not rig.camera.running
    return rig


def zero_s(rig):
    return rig.of_kind(RunStarted)[0].time_s


def test_now_means_0_V_within_50_ms_in_the_middle_of_a_pulse():
    rig = stopped(StopLevel.NOW, 6.3)
    last = rig.of_kind(VoltageSet)[-1]
    assert last.write.sheet_V == 0.0
    assert 6.3 <= last.write.before_s - zero_s(rig) <= 6.35
    assert last.step == len(TRAIN.runs[0].steps) - 1
    assert not rig.of_kind(RunStopped)[0].completed
    assert len(rig.of_kind(ReadingTaken)) == 10  # the pulse's own reading is not made


def test_the_samples_up_to_0_V_are_recorded_when_stopped_at_once():
    rig = stopped(StopLevel.NOW, 6.3)
    block = rig.of_kind(SignalsArrived)[-1].block
    clock = rig.of_kind(RunStarted)[0].sample_clock
    zero_written_s = rig.of_kind(VoltageSet)[-1].write.before_s
    assert clock.time_of(block.first_index + block.volts.shape[1]) >= zero_written_s - 1e-3


@pytest.mark.parametrize("at_s", [6.05, 6.3, 6.55])
def test_after_the_pulse_means_that_the_pulse_and_its_reading_are_completed(at_s):
    rig = stopped(StopLevel.AFTER_PULSE, at_s)
    written = rig.of_kind(VoltageSet)
    assert [w.write.sheet_V for w in written] == [0.0, 2.0, 0.0]
    assert written[-1].write.before_s - zero_s(rig) == pytest.approx(6.6, abs=0.002)
    readings = rig.of_kind(ReadingTaken)
    assert len(readings) == 11
    assert readings[-1].valid
    assert not rig.of_kind(RunStopped)[0].completed


@pytest.mark.parametrize("level", [StopLevel.AFTER_PULSE, StopLevel.NOW])
def test_at_0_V_there_is_no_pulse_to_wait_for(level):
    rig = stopped(level, 2.0)
    assert {w.write.sheet_V for w in rig.of_kind(VoltageSet)} == {0.0}
    assert rig.clock.now() - zero_s(rig) < 3.0


def test_a_request_can_become_more_urgent_but_not_less():
    rig = FakeRig()
    rig.stop.request(StopLevel.NOW, "first")
    rig.stop.request(StopLevel.AFTER_PULSE, "second")
    assert (rig.stop.level, rig.stop.why) == (StopLevel.NOW, "first")
    rig = FakeRig()
    rig.stop.request(StopLevel.AFTER_PULSE, "first")
    rig.stop.request(StopLevel.NOW, "second")
    assert (rig.stop.level, rig.stop.why) == (StopLevel.NOW, "second")


def test_a_request_in_the_last_readings_of_a_run_lets_it_complete_and_no_other_begin():
    rig = stopped(StopLevel.AFTER_PULSE, 19.25)
    assert [e.completed for e in rig.of_kind(RunStopped)] == [True]
    assert len(rig.of_kind(ReadingTaken)) == 32
    assert [p.kind for p in rig.operator.asked] == ["mount", "touch", "moisten"]
    assert rig.stage.moves == [0.0]


def test_a_session_stopped_in_its_last_run_is_not_completed():
    rig = stopped(StopLevel.AFTER_PULSE, 18.3, make_schedule(PulseTrain(), [Place("x", (0.0,))]))
    assert len(rig.of_kind(ReadingTaken)) == 31


@pytest.mark.parametrize("level", [StopLevel.AFTER_PULSE, StopLevel.NOW])
def test_a_request_while_the_operator_is_asked_ends_the_session_before_anything_else(level):
    rig = FakeRig()
    rig.operator.declines = lambda prompt: rig.stop.request(level, "STOP") or True
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.ABORTED
    assert scheduler.status.finish is FinishReason.STOP_REQUESTED
    assert not rig.of_kind(RunStarted)
    assert not scheduler.status.energised_once


@pytest.mark.parametrize("kind", ["mount", "touch", "moisten"])
def test_an_operator_who_declines_ends_the_session(kind):
    rig = FakeRig()
    rig.operator.declines = lambda prompt: prompt.kind == kind
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.ABORTED
    assert scheduler.status.finish is FinishReason.DECLINED
    assert rig.operator.asked[-1].kind == kind
    assert "stopped the session" in rig.events[-1].reason


def test_a_move_that_is_declined_ends_the_session():
    rig = FakeRig()
    rig.stage.answer = False
    assert rig.scheduler().run(short_schedule()) is Outcome.ABORTED
    assert rig.events[-1].reason == (
        "the operator was asked to move the load cell to 0 mm and stopped the session"
    )


def test_a_keyboard_interrupt_that_gets_through_is_a_stop_at_once():
    rig = FakeRig()

    def interrupt():
        raise KeyboardInterrupt

    def emit(event):
        rig.events.append(event)
        if isinstance(event, RunStarted):
            rig.clock.at.append((event.time_s + 1.5, interrupt))

    scheduler = rig.scheduler(emit=emit)
    assert scheduler.run(short_schedule()) is Outcome.ABORTED
    assert rig.output.last_V == 0.0
    assert scheduler.status.state is RunState.FINISHED
    assert rig.events[-1].reason == "interrupted from the keyboard"


def test_the_end_of_the_interpreter_leaves_0_V_and_goes_on():
    rig = FakeRig()

    def leave():
        raise SystemExit(3)

    def emit(event):
        rig.events.append(event)
        if isinstance(event, RunStarted):
            rig.clock.at.append((event.time_s + 1.5, leave))

    with pytest.raises(SystemExit):
        rig.scheduler(emit=emit).run(short_schedule())
    assert rig.output.last_V == 0.0
    assert isinstance(rig.events[-1], SessionStopped)
