"""A pause between two runs."""

from __future__ import annotations

import pytest

from labrig.testing.fake_rig import FakeRig, short_schedule
from protocols import RunState, StopLevel
from protocols.execution.events import (
    ActionTaken,
    Outcome,
    OutputChanged,
    OutputState,
    RunStarted,
    VoltageSet,
)
from protocols.execution.stop import Pause

SCHEDULE = short_schedule(0.0, 0.005, 0.01)


class Wanted:
    """A pause that is wanted until it was asked about so often."""

    def __init__(self, times=3):
        self.left = times
        self.on_ask = lambda: None

    def asked_by(self):
        self.left -= 1
        self.on_ask()
        return "Ann" if self.left >= 0 else ""


class MadeSafe:
    def __init__(self, is_safe=True):
        self.is_safe = is_safe
        self.text = "0 V written and read back" if is_safe else "0 V was not read back"


def paused(wanted, confirmed=None):
    rig = FakeRig()
    calls = []

    def confirm():
        calls.append(rig.output.last_V)
        return confirmed or MadeSafe()

    scheduler = rig.scheduler(pause=Pause(wanted, confirm))
    return rig, scheduler, calls


@pytest.mark.slow
def test_a_paused_session_is_safe_by_a_read_back_and_then_measures_the_rest():
    wanted = Wanted()
    rig, scheduler, calls = paused(wanted)
    seen = []
    wanted.on_ask = lambda: seen.append((scheduler.status.state, scheduler.status.output))
    assert scheduler.run(SCHEDULE) is Outcome.COMPLETED
    assert calls == [0.0]
    assert (RunState.PAUSED, OutputState.SAFE) in seen
    assert len(rig.of_kind(RunStarted)) == 3
    changes = [(e.state, e.why) for e in rig.of_kind(OutputChanged)]
    assert (OutputState.SAFE, "0 V written and read back") in changes


@pytest.mark.slow
def test_the_log_holds_who_paused_the_session_and_where_it_continues():
    rig, scheduler, _ = paused(Wanted())
    scheduler.run(SCHEDULE)
    assert [(e.who, e.what) for e in rig.of_kind(ActionTaken)] == [
        ("Ann", "paused the session after run 1"),
        ("labrig", "continues with run 2"),
    ]


@pytest.mark.slow
def test_no_voltage_is_written_during_a_pause():
    rig, scheduler, _ = paused(Wanted())
    scheduler.run(SCHEDULE)
    begin, end = (event.time_s for event in rig.of_kind(ActionTaken))
    assert not [e for e in rig.of_kind(VoltageSet) if begin <= e.time_s < end]


@pytest.mark.slow
def test_time_passes_during_a_pause_on_a_virtual_clock():
    rig, scheduler, _ = paused(Wanted(4))
    scheduler.run(SCHEDULE)
    begin, end = (event.time_s for event in rig.of_kind(ActionTaken))
    assert end - begin >= 0.2


def test_a_stop_ends_a_paused_session_at_0_V():
    wanted = Wanted(1000)
    rig, scheduler, _ = paused(wanted)
    wanted.on_ask = lambda: (
        scheduler.status.state is RunState.PAUSED
        and rig.stop.request(StopLevel.NOW, "STOP was pressed")
    )
    assert scheduler.run(SCHEDULE) is Outcome.ABORTED
    assert scheduler.status.text == "STOP was pressed"
    assert scheduler.status.output is OutputState.SAFE
    assert len(rig.of_kind(RunStarted)) == 1


def test_a_session_that_cannot_confirm_0_V_ends_instead_of_pausing():
    rig, scheduler, _ = paused(Wanted(), MadeSafe(is_safe=False))
    assert scheduler.run(SCHEDULE) is Outcome.FAILED
    assert "was not read back" in scheduler.status.text
    assert len(rig.of_kind(RunStarted)) == 1


def test_a_pause_that_is_withdrawn_in_time_does_not_happen():
    _rig, scheduler, calls = paused(Wanted(0))
    assert scheduler.run(SCHEDULE) is Outcome.COMPLETED
    assert calls == []


def test_nothing_pauses_after_the_last_run():
    _, scheduler, calls = paused(Wanted(1000))
    assert scheduler.run(short_schedule(0.0)) is Outcome.COMPLETED
    assert calls == []
