"""The simulated camera as an object."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sim_hardware.camera import CameraFaults, SimulatedCapture, from_frame
from sim_hardware.faults import FaultyRig
from sim_hardware.world import FaultSettings

CONVERT_RGB = 16


class JumpingClock:
    """A clock on which waiting takes no time."""

    def __init__(self, now_s: float = 100.0) -> None:
        self.now_s = now_s

    def now(self) -> float:
        return self.now_s

    def sleep_until(self, when: float) -> None:
        self.now_s = max(self.now_s, when)

    def start_thread(self, target, name):
        raise AssertionError("a capture starts no thread")


class NumberScene:
    """Every pixel shows the frame's number; remembers what was asked."""

    frame_shape = (24, 32)
    frame_rate_hz = 25.0

    def __init__(self) -> None:
        self.asked: list[tuple[int, float]] = []

    def image(self, when: float, number: int) -> np.ndarray:
        self.asked.append((number, when))
        return np.full(self.frame_shape, number % 256, dtype=np.uint8)


def grey_capture(**keywords) -> tuple[SimulatedCapture, NumberScene, JumpingClock]:
    scene, clock = NumberScene(), JumpingClock()
    capture = SimulatedCapture(scene, clock, **keywords)
    assert capture.set(CONVERT_RGB, 0)
    return capture, scene, clock


def numbers(capture: SimulatedCapture, count: int) -> list[int]:
    return [int(capture.read()[1][0, 0]) for _ in range(count)]


def test_frames_come_at_exact_multiples_of_the_period() -> None:
    capture, _, clock = grey_capture()
    times = []
    for _ in range(1000):
        assert capture.grab()
        times.append(clock.now())
    assert times == [100.0 + (k + 1) * 0.04 for k in range(1000)]
    assert capture.get(0) == pytest.approx(1000 * 40)


def test_frames_nobody_wants_are_not_rendered() -> None:
    capture, scene, _ = grey_capture()
    for _ in range(10):
        capture.grab()
    assert scene.asked == []
    good, image = capture.retrieve()
    assert good
    assert image[3, 4] == 9
    assert scene.asked == [(9, 100.0 + 10 * 0.04)]


def test_images_are_grey_or_have_three_channels_as_with_opencv() -> None:
    capture, _, _ = grey_capture()
    assert capture.read()[1].shape == (24, 32)
    capture.set(CONVERT_RGB, 1)
    assert capture.read()[1].shape == (24, 32, 3)


def test_properties_tell_size_and_rate() -> None:
    capture, _, _ = grey_capture()
    assert [capture.get(k) for k in (3, 4, 5)] == [32, 24, 25]
    assert capture.get(12345) == 0
    assert not capture.set(3, 640)


def test_a_late_reader_finds_the_buffered_frames_and_has_lost_the_others() -> None:
    capture, _, clock = grey_capture()
    assert numbers(capture, 2) == [0, 1]
    clock.now_s += 10 * 0.04
    assert numbers(capture, 5) == [8, 9, 10, 11, 12]
    capture.set(38, 1)
    clock.now_s += 10 * 0.04
    assert numbers(capture, 2) == [22, 23]


def test_jitter_only_delays_and_never_twice_alike() -> None:
    capture, _, clock = grey_capture(jitter_s=0.005)
    late = []
    for k in range(50):
        capture.grab()
        late.append(clock.now() - (100.0 + (k + 1) * 0.04))
    assert 0 <= min(late) < 0.001
    assert 0.004 < max(late) <= 0.005
    again, _, clock = grey_capture(jitter_s=0.005)
    again.grab()
    assert clock.now() - 100.04 == pytest.approx(late[0])


def test_a_released_capture_delivers_nothing_until_it_is_opened_again() -> None:
    capture, _, _ = grey_capture()
    assert numbers(capture, 2) == [0, 1]
    capture.release()
    assert not capture.isOpened()
    assert capture.read() == (False, None)
    assert capture.open("whatever")
    assert numbers(capture, 1) == [0]


def test_dropped_frames_leave_a_gap() -> None:
    capture, _, _ = grey_capture(faults=CameraFaults(drop={1, 2}))
    assert numbers(capture, 3) == [0, 3, 4]


def test_a_camera_that_hangs_lets_the_reader_time_out() -> None:
    capture, _, clock = grey_capture(faults=CameraFaults(drop=from_frame(1)))
    assert capture.grab()
    start = clock.now()
    assert not capture.grab()
    assert clock.now() - start == pytest.approx(2.0)
    capture.faults.drop = ()
    assert capture.grab()


def test_a_camera_that_is_unplugged_fails_at_once() -> None:
    capture, _, clock = grey_capture(faults=CameraFaults(gone=from_frame(2)))
    assert numbers(capture, 2) == [0, 1]
    start = clock.now()
    assert not capture.grab()
    assert capture.retrieve() == (False, None)
    assert clock.now() == start


def test_late_frames_arrive_late_and_show_their_own_time() -> None:
    capture, scene, clock = grey_capture(faults=CameraFaults(late={1}, late_s=0.03))
    capture.read()
    capture.read()
    assert clock.now() == pytest.approx(100.08 + 0.03)
    assert scene.asked[1] == (1, pytest.approx(100.08))


def test_frozen_and_black_and_small_frames() -> None:
    faults = CameraFaults(freeze={2, 3}, black={5}, wrong_size={6})
    capture, _, _ = grey_capture(faults=faults)
    assert numbers(capture, 6) == [0, 1, 1, 1, 4, 0]
    assert capture.read()[1].shape == (12, 16)
    assert capture.read()[1].shape == (24, 32)


def test_each_fault_of_a_world_acts_whatever_others_there_are() -> None:
    """Two black spans, and a delay that is not that of the fault after it."""
    capture, _, clock = grey_capture()
    faults = (
        FaultSettings(what="camera_late", from_s=0.0, until_s=0.1, amount_s=0.03),
        FaultSettings(what="camera_black", from_s=0.1, until_s=0.18),
        FaultSettings(what="camera_black", from_s=0.22, until_s=0.26),
        FaultSettings(what="camera_late", from_s=0.26, until_s=0.3, amount_s=0.01),
    )
    world = SimpleNamespace(settings=SimpleNamespace(faults=faults))
    FaultyRig(clock=clock, world=world, boards=SimpleNamespace(), camera=capture.faults).begin()
    seen, delays = [], []
    for number in range(8):
        seen.append(int(capture.read()[1][0, 0]))
        delays.append(clock.now() - (100.0 + (number + 1) * 0.04))
    assert seen == [0, 1, 0, 0, 4, 0, 6, 7]
    assert delays == pytest.approx([0.03, 0.03, 0, 0, 0, 0, 0.01, 0])
