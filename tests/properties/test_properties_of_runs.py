"""Whatever is asked for, whatever breaks: never beyond the limit, no voltage after the end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from protocols import (
    Extras,
    Place,
    Schedule,
    ScheduleError,
    make_schedule,
)
from protocols.execution.events import Outcome, OutputState
from protocols.execution.stop import StopLevel
from protocols.kinds.hold import Hold
from protocols.kinds.pulse_train import PulseTrain
from protocols.kinds.staircase import Staircase
from protocols.kinds.step_response import StepResponse
from tests.properties.witness import HALF_STEP_V, LIMITS, WitnessedRig

RUN = settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
MOST_V = LIMITS.sheet_voltage_V + HALF_STEP_V
CALLS = ("WriteAnalogF64", "ReadAnalogF64", "StartTask", "StopTask", "GetReadAttributeUInt32")
CODES = (-200088, -200279, -50103, -200561, -200324, -1)

volts = st.floats(-4.0, 4.0).map(lambda v: round(v, 2))  # the limit is 2.5 V
seconds = st.sampled_from([0.3, 0.5, 1.0])


def _made(kind: Callable[..., Any]) -> Callable[[dict[str, Any]], Any]:
    def make(values: dict[str, Any]) -> Any:
        try:
            return kind(**values)
        except ScheduleError:
            return None

    return make


protocols = st.one_of(
    st.fixed_dictionaries(
        {
            "voltages_V": st.lists(volts, min_size=1, max_size=3).map(tuple),
            "zero_readings": st.integers(0, 2),
            "pulses_discarded": st.integers(0, 1),
            "readings_per_voltage": st.integers(1, 2),
            "rest_s": st.sampled_from([0.0, 0.2]),
        }
    ).map(_made(PulseTrain)),
    st.fixed_dictionaries({"voltage_V": volts, "hold_s": seconds, "after_s": seconds}).map(
        _made(StepResponse)
    ),
    st.fixed_dictionaries({"voltages_V": st.lists(volts, min_size=1, max_size=4).map(tuple)}).map(
        _made(Staircase)
    ),
    st.fixed_dictionaries({"voltage_V": volts, "cycles": st.integers(1, 2), "hold_s": seconds}).map(
        _made(Hold)
    ),
).filter(lambda protocol: protocol is not None)
extras = st.builds(
    Extras,
    remounts=st.integers(0, 1),
    no_touch_zero=st.booleans(),
    reversed_approach=st.booleans(),
    random_order_seed=st.none() | st.integers(0, 3),
)


@st.composite
def schedules(draw: st.DrawFn) -> Schedule:
    places = [Place("long", tuple(draw(st.sampled_from([(0.0,), (0.0, 0.01)]))))]
    return make_schedule(draw(protocols), places, extras=draw(extras))


@dataclass(frozen=True)
class Mishap:
    """Something that goes wrong at a moment of virtual time."""

    at_s: float
    kind: str
    call: str
    code: int

    def strike(self, rig: WitnessedRig) -> None:
        """Let it happen."""
        faults = rig.server.faults
        match self.kind:
            case "refuse":
                faults.refuse[self.call] = self.code
            case "once":
                faults.refuse[self.call] = self.code
                rig.at(rig.clock.now() + 0.3, faults.refuse.clear)
            case "lost samples":
                faults.lose_after_reads = 0
            case "slow":
                faults.delay_s = 0.2
            case "not a number":
                faults.nan.update({"PCI6034E/ai0", "PCI6034E/ai2"})
            case "unavailable":
                faults.unavailable = True
            case "stuck":
                faults.stuck_outputs.add("PCI6703/ao0")
            case "stop":
                rig.stop.request(StopLevel.AFTER_PULSE, "asked for")
            case "stop now":
                rig.stop.request(StopLevel.NOW, "asked for")
            case "person":
                rig.person.refuses = True


KINDS = ("refuse", "once", "lost samples", "slow", "not a number", "stop", "stop now", "person")
DEADLY = ("unavailable", "stuck")  # nobody can write 0 V then


def mishaps(kinds: tuple[str, ...]) -> st.SearchStrategy[Mishap]:
    return st.builds(
        Mishap,
        st.floats(0.0, 12.0),
        st.sampled_from(kinds),
        st.sampled_from(CALLS),
        st.sampled_from(CODES),
    )


def run(rig: WitnessedRig, schedule: Schedule, happen: list[Mishap]) -> tuple[Outcome, OutputState]:
    """Run a schedule in which things go wrong, as labrig does, to the last closed device."""
    for mishap in happen:
        rig.at(mishap.at_s, lambda m=mishap: m.strike(rig))
    scheduler = rig.scheduler()
    outcome = scheduler.run(schedule)
    return outcome, scheduler.status.output


def later(rig: WitnessedRig) -> list[float]:
    """The voltages of the minute after the end."""
    end = len(rig.witness.volts)
    rig.clock.sleep_until(rig.clock.now() + 60.0)
    return rig.witness.volts[end:]


@pytest.mark.slow
@RUN
@given(schedules())
def test_without_mishaps_what_is_within_the_limits_is_done_and_ends_at_0_V(
    schedule: Schedule,
) -> None:
    rig = WitnessedRig()
    try:
        outcome, output = run(rig, schedule, [])
    except ScheduleError:
        assert rig.witness.largest_V == 0.0
        return
    largest_V = max(abs(step.voltage_V) for planned in schedule.runs for step in planned.steps)
    assert rig.witness.largest_V == pytest.approx(largest_V, abs=HALF_STEP_V)
    assert (outcome, output) == (Outcome.COMPLETED, OutputState.SAFE)
    assert rig.witness.largest_V <= MOST_V
    assert rig.witness.volts[-1] == 0.0
    assert not any(later(rig))


@pytest.mark.slow
@RUN
@given(schedules(), st.lists(mishaps(KINDS), min_size=1, max_size=3))
def test_whatever_goes_wrong_with_all_but_the_writes_0_V_is_what_is_left(
    schedule: Schedule, happen: list[Mishap]
) -> None:
    harmless = [m for m in happen if m.kind not in ("refuse", "once") or m.call != CALLS[0]]
    rig = WitnessedRig()
    try:
        _, output = run(rig, schedule, harmless)
    except ScheduleError:
        output = OutputState.SAFE
    assert rig.witness.largest_V <= MOST_V
    assert rig.witness.volts[-1] == 0.0
    assert output in (OutputState.SAFE, OutputState.UNKNOWN)
    assert not any(later(rig))
    assert rig.guarded[-1:] in ([], [False])  # the guard knows that it is over


@pytest.mark.slow
@RUN
@given(schedules(), st.lists(mishaps(KINDS + DEADLY), min_size=1, max_size=4))
def test_safe_is_said_only_of_0_V_and_the_limit_holds_whatever_goes_wrong(
    schedule: Schedule, happen: list[Mishap]
) -> None:
    rig = WitnessedRig()
    try:
        _, output = run(rig, schedule, happen)
    except ScheduleError:
        output = OutputState.SAFE
    assert rig.witness.largest_V <= MOST_V
    if output is OutputState.SAFE:
        assert rig.witness.volts[-1] == 0.0
    else:
        assert output is OutputState.UNKNOWN  # for whoever called: the guard's turn
    assert not any(later(rig))


@pytest.mark.slow
@RUN
@given(schedules(), st.integers(0, 60))
def test_a_recording_that_breaks_at_any_event_ends_at_0_V(schedule: Schedule, at: int) -> None:
    rig = WitnessedRig()
    count = 0

    def emit(event: object) -> None:
        nonlocal count
        count += 1
        if count > at:
            raise OSError(28, "No space left on device")

    scheduler = rig.scheduler(emit)
    try:
        outcome = scheduler.run(schedule)
    except ScheduleError:
        return
    assert rig.witness.volts[-1] == 0.0
    assert rig.witness.largest_V <= MOST_V
    assert scheduler.status.output is OutputState.SAFE
    assert outcome is (Outcome.FAILED if count > at else Outcome.COMPLETED)
