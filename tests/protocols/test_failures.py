"""Whatever fails, whenever: 0 V first, and the end is told."""

import itertools
import sys
from dataclasses import replace

import numpy as np
import pytest

from drivers.interfaces import DeviceError, OverloadError, OvervoltageError
from labrig.testing.fake_rig import FakeRig, short_schedule
from protocols import EventBus, FinishReason, LoopTiming, RunState
from protocols.execution.channels import force_channel
from protocols.execution.events import (
    Outcome,
    OutputChanged,
    OutputState,
    RunStarted,
    RunStopped,
    SessionStopped,
    VoltageSet,
    Warned,
)
from protocols.execution.rules import Rules, check_drive

# Fewer calls to fail, one after another.
COARSE = LoopTiming(service_s=0.1, starved_s=1.0)
# Calls of each device by which the end is made safe.
END_CALLS = {"output": 1, "signals": 2}


def healthy_calls(device):
    rig = FakeRig()
    rig.scheduler(timing=COARSE).run(short_schedule(0.0, 0.005))
    return rig.faults[device].names


def fail(device, fails_at):
    rig = FakeRig()
    rig.faults[device].fail_at = fails_at
    scheduler = rig.scheduler(timing=COARSE)
    outcome = scheduler.run(short_schedule(0.0, 0.005))
    return rig, scheduler, outcome


def check_end(rig, scheduler, outcome):
    stopped = rig.of_kind(SessionStopped)
    assert len(stopped) == 1
    assert rig.events[-1] is stopped[0]
    assert stopped[0].outcome is outcome
    assert rig.output.last_V == 0.0
    assert (stopped[0].output is OutputState.SAFE) is (scheduler.status.state is RunState.FINISHED)
    started, ended = rig.of_kind(RunStarted), rig.of_kind(RunStopped)
    assert [e.run.index for e in started] == [e.run for e in ended]
    assert not rig.guarded or rig.guarded[-1] is False


@pytest.mark.slow
@pytest.mark.parametrize("device", ["output", "signals", "camera", "stage", "operator"])
def test_a_device_that_fails_once_at_any_call_leaves_0_V_and_an_end(device):
    for k, name in enumerate(healthy_calls(device)):
        rig, scheduler, outcome = fail(device, lambda index, k=k: index == k)
        check_end(rig, scheduler, outcome)
        if outcome is Outcome.FAILED:
            assert scheduler.status.finish is FinishReason.DEVICE_FAULT
            assert f"call {k} ({name}) failed" in rig.events[-1].reason
        elif k >= len(healthy_calls(device)) - END_CALLS.get(device, 0):
            # While making safe, at the second attempt; told all the same.
            assert rig.events[-1].output is OutputState.SAFE
            assert f"(but call {k} ({name}) failed)" in rig.of_kind(OutputChanged)[-1].why
        else:  # while cleaning up: the data are complete
            assert name in {"counts", "frames"}
            assert any(f"call {k} ({name}) failed" in w.text for w in rig.of_kind(Warned))


@pytest.mark.slow
@pytest.mark.parametrize("device", ["signals", "camera", "stage", "operator"])
def test_a_device_that_fails_for_good_at_any_call_leaves_0_V_and_an_end(device):
    for k in range(len(healthy_calls(device))):
        rig, scheduler, outcome = fail(device, lambda index, k=k: index >= k)
        check_end(rig, scheduler, outcome)
        if device == "signals":  # nobody can read back any more
            assert rig.events[-1].output is OutputState.UNKNOWN
            assert "switch the amplifier off" in rig.events[-1].reason


def test_an_output_that_fails_for_good_is_unknown_and_stays_guarded():
    for k in range(1, len(healthy_calls("output"))):
        rig, scheduler, _ = fail("output", lambda index, k=k: index >= k)
        assert rig.events[-1].output is OutputState.UNKNOWN
        assert scheduler.status.state is RunState.UNKNOWN
        reason = rig.events[-1].reason
        assert reason.startswith(
            "THE OUTPUT IS NOT KNOWN TO BE SAFE"
        )  # what hands must do is first
        assert "switch the amplifier off by hand" in reason
        assert "what ended the session: " in reason
        if rig.output.last_V != 0.0:
            assert rig.guarded[-1] is True  # so the guard, hearing no beat, acts


@pytest.mark.slow
@pytest.mark.parametrize("device", ["signals", "camera"])
def test_0_V_is_written_before_anything_is_told_of_a_failure(device):
    energised_failures = 0
    for k in range(len(healthy_calls(device))):
        rig, log = FakeRig(), []

        def fails(index, k=k, log=log, rig=rig):
            if index == k:
                log.append(f"failed at {rig.output.last_V:g} V")
            return index == k

        def emit(event, rig=rig, log=log):
            rig.events.append(event)
            on = rig.guarded and rig.guarded[-1]
            log.append(f"event, output at {rig.output.last_V:g} V, guard {'on' if on else 'off'}")

        rig.faults[device].fail_at = fails
        rig.scheduler(emit=emit, timing=COARSE).run(short_schedule(0.0, 0.005))
        failed = next(i for i, entry in enumerate(log) if entry.startswith("failed"))
        if log[failed] != "failed at 0 V":
            energised_failures += 1
            assert log[failed + 1] == "event, output at 0 V, guard off"
    assert energised_failures > 20


def test_an_output_that_recovers_is_tried_again():
    rig = FakeRig()
    # The first pulse fails, and so do the first two attempts at 0 V.
    rig.faults["output"].fail_at = lambda index: 2 <= index < 5
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert rig.output.last_V == 0.0
    assert rig.events[-1].output is OutputState.SAFE


def test_where_0_V_is_refused_the_operator_learns_at_once_why():
    rig = FakeRig()
    rig.faults["output"].fail_at = lambda index: 2 <= index < 5
    rig.scheduler().run(short_schedule())
    (told,) = (e.why for e in rig.of_kind(OutputChanged) if "COULD NOT BE WRITTEN" in e.why)
    assert told.startswith("0 V COULD NOT BE WRITTEN: switch the amplifier off by hand (")
    assert "broken off: call 2 (write) failed)" in told


def test_a_voltage_that_stays_at_the_sheet_is_found_by_the_read_back():
    rig = FakeRig()
    rig.signals.spoil = lambda times_s, volts: volts.__setitem__(2, 1.9)
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert scheduler.status.state is RunState.UNKNOWN
    assert (
        "switch the amplifier off by hand; the drive voltage reads 1.900 V" in rig.events[-1].reason
    )
    assert rig.of_kind(OutputChanged)[-1].state is OutputState.UNKNOWN


def test_a_sheet_that_keeps_its_voltage_ends_the_session_before_the_operator_is_asked_again():
    rig = FakeRig()
    stuck_V = [0.0]

    def keep(_times_s, volts):
        stuck_V.append(rig.output.last_V or stuck_V[-1])
        volts[2] = stuck_V[-1]

    rig.signals.spoil = keep
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule(0.0, 0.01)) is Outcome.FAILED
    assert scheduler.status.state is RunState.UNKNOWN
    assert len(rig.of_kind(RunStarted)) == 1
    zero = rig.of_kind(VoltageSet)[-1]
    assert zero.write.sheet_V == 0.0
    (stopped,) = rig.of_kind(RunStopped)
    assert stopped.time_s - zero.time_s < 0.7
    assert "0 V was written" in rig.events[-1].reason


def test_a_voltage_that_falls_slowly_after_the_last_step_delays_the_end_of_the_run_alone():
    rig = FakeRig()

    def lag(times_s, volts):
        volts[2] = rig.output.volts_at(times_s - 0.35)

    rig.signals.spoil = lag
    assert rig.scheduler().run(short_schedule(0.0, 0.01)) is Outcome.COMPLETED
    assert len(rig.of_kind(RunStarted)) == 2


def test_a_read_back_that_is_no_number_is_not_taken_for_0_V():
    rig = FakeRig()
    rig.signals.measure = lambda duration_s: np.full((3, 10), np.nan)
    scheduler = rig.scheduler()
    scheduler.run(short_schedule())
    assert scheduler.status.output is OutputState.UNKNOWN


def test_an_overloaded_load_cell_trips_the_session():
    rig = FakeRig()

    def protect(volts):
        if np.abs(volts).max(initial=0.0) > 0.0015:
            raise OverloadError("the load cell carries 130 mN: unload it at once")

    object.__setattr__(rig.devices, "protect", protect)
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert scheduler.status.finish is FinishReason.OVERLOAD
    assert "130 mN" in rig.events[-1].reason
    pulse, zero = rig.of_kind(VoltageSet)[-2:]
    assert (pulse.write.sheet_V, zero.write.sheet_V) == (2.0, 0.0)
    assert zero.write.after_s - pulse.write.after_s < 0.05


def test_an_input_that_falls_silent_is_a_fault_within_its_time():
    rig = FakeRig()

    def emit(event):
        rig.events.append(event)
        if isinstance(event, VoltageSet) and event.write.sheet_V:
            rig.signals.silent = True

    scheduler = rig.scheduler(emit=emit, timing=LoopTiming(starved_s=0.4))
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert "no samples for 0.4 s" in rig.events[-1].reason
    pulses = [w for w in rig.of_kind(VoltageSet) if w.write.sheet_V]
    assert len(pulses) == 1


def test_a_missing_channel_is_found_before_the_first_voltage():
    rig = FakeRig()
    rig.signals.channels = ("force", "current", "sense")
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert "no channel 'drive', only force, current, sense" in scheduler.status.text
    assert not scheduler.status.energised_once


def test_a_channel_without_a_meaning_is_found_before_the_first_voltage():
    rig = FakeRig()
    rig.devices = replace(rig.devices, channels=rig.devices.channels[::2])
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert "what the volts of the channel 'current' mean is not known" in scheduler.status.text
    assert not scheduler.status.energised_once


@pytest.mark.slow
def test_a_recording_that_fails_at_any_event_ends_the_session_at_0_V():
    rig = FakeRig()
    rig.scheduler(timing=COARSE).run(short_schedule())
    for k in range(len(rig.events)):
        broken, count, watched = FakeRig(), itertools.count(), []
        event_bus = EventBus(threaded=False)

        def write(event, k=k, count=count):
            if next(count) >= k:
                raise OSError("disk full")

        event_bus.add_required("the session file", write)
        event_bus.add_best_effort("progress", watched.append)
        scheduler = broken.scheduler(emit=event_bus.emit, timing=COARSE)
        assert scheduler.run(short_schedule()) is Outcome.FAILED
        assert scheduler.status.finish is FinishReason.RECORDING_FAULT
        assert "disk full" in scheduler.status.text
        assert broken.output.last_V == 0.0
        assert isinstance(watched[-1], SessionStopped)
        assert scheduler.status.output is OutputState.SAFE


def test_a_watcher_that_fails_at_every_event_changes_nothing():
    def voltages(break_it):
        rig, event_bus = FakeRig(), EventBus(threaded=False)
        event_bus.add_required("file", rig.events.append)
        if break_it:
            event_bus.add_best_effort("panel", lambda event: 1 / 0)
        assert rig.scheduler(emit=event_bus.emit).run(short_schedule()) is Outcome.COMPLETED
        return rig.of_kind(VoltageSet), rig.of_kind(Warned)

    healthy, broken = voltages(break_it=False), voltages(break_it=True)
    assert healthy[0] == broken[0]
    assert (len(healthy[1]), len(broken[1])) == (0, 1)


@pytest.mark.parametrize("hook", ["beat", "on_energised"])
def test_a_guard_that_has_died_ends_the_session_at_0_V(hook):
    rig = FakeRig()

    def dead(*_):
        if rig.output.last_V or hook == "on_energised":
            raise BrokenPipeError("the guard is gone")

    scheduler = rig.scheduler(**{hook: dead})
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert "the guard is gone" in rig.events[-1].reason
    assert rig.output.last_V == 0.0
    assert rig.events[-1].output is OutputState.SAFE


def test_an_operator_who_cannot_be_asked_is_named_as_the_reason():
    rig = FakeRig()

    def ask(prompt):
        raise EOFError("standard input has ended")

    rig.operator.ask = ask
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert scheduler.status.finish is FinishReason.NO_ANSWER
    assert rig.events[-1].reason == "standard input has ended"
    assert isinstance(scheduler.status.error.__cause__, EOFError)


def _no_such_thing(*_):
    return {}["at"]


@pytest.mark.parametrize("method", ["move_to", "position"])
def test_a_stage_whose_code_is_wrong_is_named_with_the_place_in_it(method):
    rig = FakeRig()
    setattr(rig.stage, method, _no_such_thing)
    asked = []

    def whose(error):
        asked.append(error)
        return "their-stage 2.0 (stage.py, line 3)"

    scheduler = rig.scheduler(whose=whose)
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert scheduler.status.finish is FinishReason.DEVICE_FAULT
    assert rig.events[-1].reason == (
        "the stage failed: KeyError: 'at', in their-stage 2.0 (stage.py, line 3)"
    )
    assert [type(error) for error in asked] == [KeyError]


@pytest.mark.parametrize("fault", [RuntimeError("belt snapped"), OSError("belt snapped")])
def test_a_stage_that_fails_in_any_other_way_is_named_with_the_place_in_it(fault):
    rig = FakeRig()

    def snap(_position_m):
        raise fault

    rig.stage.move_to = snap
    asked = []

    def whose(error):
        asked.append(error)
        return "their-stage 2.0 (stage.py, line 3)"

    scheduler = rig.scheduler(whose=whose)
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert rig.events[-1].reason == (
        "the stage failed: belt snapped, in their-stage 2.0 (stage.py, line 3)"
    )
    assert asked == [fault]


def test_nobody_is_blamed_for_an_operator_who_cannot_be_asked():
    rig = FakeRig()

    def ask(_prompt):
        raise RuntimeError("the page is closed")

    rig.operator.ask = ask
    scheduler = rig.scheduler(whose=lambda _: "their-page 2.0 (page.py, line 3)")
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert rig.events[-1].reason == "the page is closed"


def test_a_stage_that_ends_the_program_ends_the_session_at_0_V():
    rig = FakeRig()
    rig.stage.move_to = lambda _position_m: sys.exit(3)
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert rig.events[-1].reason == "the stage failed: SystemExit: 3"


@pytest.mark.parametrize("answer", [None, 1, "moved"])
def test_a_stage_that_answers_neither_true_nor_false_is_blamed_and_not_the_operator(answer):
    rig = FakeRig()
    rig.devices = replace(rig.devices, stage_name="belt")
    rig.stage.move_to = lambda _position_m: answer
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert scheduler.status.finish is FinishReason.DEVICE_FAULT
    assert rig.events[-1].reason == (
        f"the stage 'belt' answered {answer!r} to move_to, neither True nor False"
    )


def test_a_device_that_says_itself_what_is_wrong_with_it_is_no_mistake_in_a_part():
    rig = FakeRig()

    def stuck(_position_m):
        raise DeviceError("the stage is stuck; free it")

    rig.stage.move_to = stuck
    scheduler = rig.scheduler(whose=lambda _: "their-stage 2.0 (stage.py, line 3)")
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert rig.events[-1].reason == "the stage is stuck; free it"


def test_a_mistake_in_a_part_of_another_distribution_is_not_labrigs():
    rig = FakeRig()
    broken = force_channel(range_V=0.05, conversion=_no_such_thing)
    rig.devices = replace(rig.devices, channels=(broken, *rig.devices.channels[1:]))
    scheduler = rig.scheduler(whose=lambda _: "their-cell 2.0 (cell.py, line 3)")
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert scheduler.status.finish is FinishReason.INTERNAL_ERROR
    assert rig.events[-1].reason == (
        "a part of another distribution failed: KeyError: 'at', in their-cell 2.0 (cell.py, line 3)"
    )


def test_a_mistake_in_the_program_is_named_as_such():
    rig = FakeRig()
    broken = force_channel(range_V=0.05, conversion=lambda volts: volts.no_such_thing)
    rig.devices = replace(rig.devices, channels=(broken, *rig.devices.channels[1:]))
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule()) is Outcome.FAILED
    assert scheduler.status.finish is FinishReason.INTERNAL_ERROR
    assert isinstance(scheduler.status.error, AttributeError)
    assert "an error in labrig itself: AttributeError" in rig.events[-1].reason


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    "drive_V",
    [[], [2.7] * 5, [-2.7] * 5, [NAN] * 5, [5.0, 5.0, 0.0, 0.0, 0.0], [5.0, NAN, 0.0, 0.0]],
    ids=str,
)
def test_a_read_back_is_within_the_limit_where_most_of_it_is(drive_V):
    check_drive(np.array(drive_V), 2.5, Rules())


@pytest.mark.parametrize(
    "drive_V",
    [[2.71] * 5, [-2.71] * 5, [3.0, 3.0, 3.0, 0.0, 0.0], [3.0, NAN, NAN, NAN], [3.0, 3.0, INF]],
    ids=str,
)
def test_a_read_back_is_beyond_the_limit_where_most_of_it_is(drive_V):
    with pytest.raises(OvervoltageError, match=r"beyond the limit of 2\.5 V"):
        check_drive(np.array(drive_V), 2.5, Rules())


def test_whose_part_failed_is_asked_at_0_V_and_need_not_be_known():
    rig, asked = FakeRig(), []

    def broken_under_voltage(_index):
        if rig.output.last_V != 0.0:
            raise KeyError("volts")
        return False

    def whose(error):
        asked.append((type(error), rig.output.last_V))
        raise OSError("what is installed cannot be read")

    rig.faults["signals"].fail_at = broken_under_voltage
    scheduler = rig.scheduler(timing=COARSE, whose=whose)
    outcome = scheduler.run(short_schedule(0.0))
    check_end(rig, scheduler, outcome)
    assert asked == [(KeyError, 0.0)]
    assert scheduler.status.finish is FinishReason.INTERNAL_ERROR
