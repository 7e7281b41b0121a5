"""Runs whose readings were lost are offered again while the sheet is still mounted."""

from __future__ import annotations

import pytest

from drivers.interfaces import Prompt
from labrig.testing.fake_rig import SHORT_TRAIN, FakeRig
from protocols import Place, make_schedule, schedule_from_dict, schedule_to_dict
from protocols.execution.events import Outcome, ReadingTaken, RunStarted
from protocols.execution.stop import StopLevel

SCHEDULE = make_schedule(SHORT_TRAIN, [Place("long", (0.0, 0.005)), Place("short", (0.005,))])


def losing(rig: FakeRig, first_s: float, last_s: float) -> None:
    """The camera shows nothing from a moment of the session to another: readings do not count."""
    began_s = rig.clock.now()
    grabbed = rig.devices.camera.frames

    def frames() -> list:
        if first_s < rig.clock.now() - began_s < last_s:
            grabbed()
            return []
        return grabbed()

    rig.devices.camera.frames = frames


def executed(rig: FakeRig) -> list[int]:
    return [event.run.index for event in rig.of_kind(RunStarted)]


def questions(rig: FakeRig) -> list[str]:
    return [prompt.kind for prompt in rig.operator.asked]


def again(prompt: Prompt) -> bool:
    return prompt.kind == "repeat"


def test_a_run_with_lost_readings_is_offered_before_the_sheet_is_dismounted() -> None:
    rig = FakeRig()
    losing(rig, 0.0, 10.0)
    outcome = rig.scheduler().run(SCHEDULE)
    assert outcome is Outcome.COMPLETED
    asked = questions(rig)
    assert asked.count("repeat") == 1
    mounts = [place for place, kind in enumerate(asked) if kind == "mount"]
    assert asked.index("repeat") == mounts[1] - 1
    text = next(p.text for p in rig.operator.asked if p.kind == "repeat")
    assert "readings of run 1 (long, 0 mm) do not count: no frame" in text
    assert executed(rig) == [0, 1, 2]  # who says go on repeats nothing


def test_the_repeat_is_a_run_of_its_own_at_the_same_place() -> None:
    rig = FakeRig()
    losing(rig, 0.0, 10.0)
    rig.operator.declines = again
    assert rig.scheduler().run(SCHEDULE) is Outcome.COMPLETED
    assert executed(rig) == [0, 1, 3, 2]
    first, _, repeat, _ = [event.run for event in rig.of_kind(RunStarted)]
    assert repeat.repeats == first.index
    assert (repeat.configuration, repeat.position_m) == (first.configuration, first.position_m)
    assert (repeat.steps, repeat.readings) == (first.steps, first.readings)
    taken = [e for e in rig.of_kind(ReadingTaken) if e.run == repeat.index]
    assert len(taken) == len(repeat.readings)
    assert all(event.valid for event in taken)
    assert questions(rig).count("repeat") == 1


def test_the_last_runs_are_offered_before_the_session_ends() -> None:
    rig = FakeRig()
    losing(rig, 20.0, 1e9)
    assert rig.scheduler().run(SCHEDULE) is Outcome.COMPLETED
    assert questions(rig)[-1] == "repeat"


def test_nothing_is_offered_when_every_reading_counts() -> None:
    rig = FakeRig()
    rig.scheduler().run(SCHEDULE)
    assert "repeat" not in questions(rig)


def test_a_stop_while_it_is_offered_stops_the_session_and_repeats_nothing() -> None:
    rig = FakeRig()
    losing(rig, 0.0, 10.0)

    def stops(prompt: Prompt) -> bool:
        if again(prompt):
            rig.stop.request(StopLevel.NOW, "STOP was pressed")
        return again(prompt)

    rig.operator.declines = stops
    assert rig.scheduler().run(SCHEDULE) is Outcome.ABORTED
    assert executed(rig) == [0, 1]


@pytest.mark.parametrize("positions_m", [(0.0,), (0.0, 0.01, 0.02)])
def test_a_schedule_with_its_repeats_survives_as_plain_data(positions_m: tuple[float, ...]) -> None:
    schedule = make_schedule(SHORT_TRAIN, [Place("long", positions_m)])
    assert len(schedule.repeats) == len(positions_m)
    assert schedule_from_dict(schedule_to_dict(schedule)) == schedule
    plain = schedule_to_dict(schedule)
    del plain["repeats"]  # as a session from before there were repeats has it
    assert schedule_from_dict(plain).repeats == ()
