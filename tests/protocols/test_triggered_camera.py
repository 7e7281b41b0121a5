"""A camera that is triggered: when each exposure begins, and which frame is whose."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from drivers.interfaces import (
    HARDWARE,
    AcquisitionSettings,
    CameraCounts,
    DeviceError,
    DeviceTimeoutError,
    Frame,
    TriggerPulse,
)
from labrig.testing.fake_devices import FakeCamera
from labrig.testing.fake_rig import FakeRig, short_schedule
from protocols.execution.events import Outcome, ReadingTaken, RunStopped, SessionStopped, VoltageSet
from protocols.execution.runs.exposures import Exposures

EXPOSURE_S = 0.008
ROUND_TRIP_S = 0.0004
TRANSFER_S = 0.003


class TriggeredCamera(FakeCamera):
    """Exposes when its line is pulsed; `ignores` says which trigger it does not see."""

    settings = AcquisitionSettings(exposure_s=EXPOSURE_S, trigger=HARDWARE)

    def __init__(self, rig: FakeRig) -> None:
        super().__init__(rig.clock, rig.faults["camera"])
        self.exposed_s: list[float] = []
        self.fired = 0
        self.handed = 0
        self.ignores = lambda number: False
        self.fails = lambda number: False
        self.transfer_s = TRANSFER_S

    # what triggers it
    def fire(self) -> TriggerPulse:
        number, self.fired = self.fired, self.fired + 1
        if self.fails(number):
            raise DeviceTimeoutError("the trigger was not confirmed")
        before_s = self.clock.time_s
        if not self.ignores(number):
            self.exposed_s.append(before_s + ROUND_TRIP_S / 2)
        self.clock.time_s += ROUND_TRIP_S
        return TriggerPulse(before_s, self.clock.time_s)

    def frames(self) -> list[Frame]:
        found = []
        while self.handed < len(self.exposed_s):
            began_s = self.exposed_s[self.handed]
            came_s = began_s + EXPOSURE_S + self.transfer_s
            if came_s > self.clock.time_s:
                break
            frame = replace(self._frame(self.handed), time_s=came_s)
            found.append(replace(frame, device_time_s=7000.0 + 1.0001 * began_s))
            self.handed += 1
        return found

    @property
    def counts(self) -> CameraCounts:
        return CameraCounts(self.handed, 0)


@pytest.fixture
def rig() -> FakeRig:
    rig = FakeRig()
    rig.camera = TriggeredCamera(rig)
    rig.devices = replace(rig.devices, camera=rig.camera, trigger=rig.camera)
    return rig


def readings(rig: FakeRig) -> list[ReadingTaken]:
    return rig.of_kind(ReadingTaken)


def test_the_middle_of_each_exposure_is_the_sampling_point(rig: FakeRig) -> None:
    assert rig.scheduler().run(short_schedule()) is Outcome.COMPLETED
    taken = readings(rig)
    assert len(taken) == len(rig.camera.exposed_s) == 5
    for reading, exposed_s in zip(taken, rig.camera.exposed_s, strict=True):
        assert reading.valid, reading.why
        assert reading.frame is not None
        assert reading.frame_offset_s == pytest.approx(
            exposed_s + EXPOSURE_S / 2 - reading.sample_time_s
        )
        assert abs(reading.frame_offset_s) < ROUND_TRIP_S
        assert reading.frame.trigger_s == pytest.approx(exposed_s)
    (stopped,) = rig.of_kind(RunStopped)
    assert (stopped.frames_grabbed, stopped.frames_missed, stopped.losses) == (5, 0, "")


def test_edges_stay_in_time(rig: FakeRig) -> None:
    rig.scheduler().run(short_schedule())
    late_s = [each.write.before_s - each.due_s for each in rig.of_kind(VoltageSet)]
    assert max(late_s) <= 1e-9


def test_where_all_frames_are_kept_it_exposes_in_the_protocols_rhythm(rig: FakeRig) -> None:
    rig.scheduler(keep_all_frames=True).run(short_schedule())
    taken = readings(rig)
    assert all(each.valid for each in taken)
    assert max(abs(each.frame_offset_s or math.inf) for each in taken) < ROUND_TRIP_S
    gaps_s = [b - a for a, b in zip(rig.camera.exposed_s, rig.camera.exposed_s[1:], strict=False)]
    assert min(gaps_s) > 0.5 * 0.04
    assert max(gaps_s) < 1.7 * 0.04


def test_a_frame_that_comes_after_the_next_trigger_is_still_that_of_its_own(rig: FakeRig) -> None:
    rig.camera.transfer_s = 0.038  # longer than from one trigger to the next
    rig.scheduler(keep_all_frames=True).run(short_schedule())
    for reading in readings(rig):
        assert reading.frame is not None
        began_s = rig.camera.exposed_s[reading.frame.number]
        assert reading.frame.trigger_s == pytest.approx(began_s)
        assert abs(reading.frame_offset_s or math.inf) < ROUND_TRIP_S


def test_a_trigger_that_it_does_not_see_is_a_missed_frame_and_spoils_its_reading(
    rig: FakeRig,
) -> None:
    rig.camera.ignores = lambda number: number == 2
    assert rig.scheduler().run(short_schedule()) is Outcome.COMPLETED
    assert [each.valid for each in readings(rig)] == [True, True, False, True, True]
    assert "no frame within" in readings(rig)[2].why
    (stopped,) = rig.of_kind(RunStopped)
    assert stopped.frames_missed == 1
    assert stopped.losses == "0 samples and 1 frames were lost (1 never came)"


def test_a_trigger_that_is_not_confirmed_costs_its_frame_and_not_the_run(rig: FakeRig) -> None:
    rig.camera.fails = lambda number: number == 1
    assert rig.scheduler().run(short_schedule()) is Outcome.COMPLETED
    assert [each.valid for each in readings(rig)] == [True, False, True, True, True]


def test_a_camera_that_answers_no_trigger_ends_the_run_at_0_V(rig: FakeRig) -> None:
    rig.camera.ignores = lambda number: number > 1
    scheduler = rig.scheduler(keep_all_frames=True)
    assert scheduler.run(short_schedule(0.0, 0.01)) is Outcome.FAILED
    (stopped,) = rig.of_kind(SessionStopped)
    assert "no frame for the last 5 triggers" in stopped.reason
    assert rig.output.last_V == 0.0


def test_a_line_that_fails_ends_the_run_at_0_V(rig: FakeRig) -> None:
    def broken() -> TriggerPulse:
        raise DeviceError("the board is gone")

    rig.camera.fire = broken
    assert rig.scheduler().run(short_schedule()) is Outcome.FAILED
    (stopped,) = rig.of_kind(SessionStopped)
    assert "the board is gone" in stopped.reason
    assert rig.output.last_V == 0.0


def test_without_a_rhythm_only_sampling_points_are_due(rig: FakeRig) -> None:
    exposures = Exposures(rig.camera, rig.clock, EXPOSURE_S)
    assert exposures.next_s == math.inf
    exposures.expect(200.0)
    exposures.expect(150.0)
    assert exposures.next_s == pytest.approx(150.0 - EXPOSURE_S / 2)
    exposures.fire()
    assert exposures.next_s == pytest.approx(200.0 - EXPOSURE_S / 2)
    assert (exposures.fired, exposures.unanswered) == (1, 1)
