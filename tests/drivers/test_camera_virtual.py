"""The camera driver on the virtual clock: which frames are kept, and when they were taken."""

import numpy as np
import pytest

from drivers.cameras.capture_camera import CaptureCamera
from drivers.interfaces import DeviceError
from sim_hardware.camera import CameraFaults, SimulatedCapture, from_frame
from sim_hardware.clock import VirtualClock

PERIOD_S = 0.04


class CountingScene:
    """Counts how many pictures were rendered."""

    frame_shape = (4, 6)
    frame_rate_hz = 1.0 / PERIOD_S

    def __init__(self) -> None:
        self.rendered: list[int] = []

    def image(self, when: float, number: int) -> np.ndarray:
        self.rendered.append(number)
        return np.full(self.frame_shape, number % 256, dtype=np.uint8)


@pytest.fixture
def clock():
    return VirtualClock()


def simulated(clock, scene, faults=None, **kwargs) -> CaptureCamera:
    camera = CaptureCamera(
        "simulated", clock, lambda _: SimulatedCapture(scene, clock, faults=faults), **kwargs
    )
    camera.open()
    return camera


def test_only_wanted_frames_are_rendered_and_all_are_counted(clock):
    scene = CountingScene()
    camera = simulated(clock, scene)
    rendered_by_opening = len(scene.rendered)
    camera.start()
    began = clock.now()
    camera.want(began + 0.49, began + 0.57)
    camera.want(began + 1.03, began + 1.05)
    clock.sleep_until(began + 2.0)
    frames = camera.frames()
    camera.close()
    times = [frame.time_s - began for frame in frames]
    assert times == pytest.approx([0.52, 0.56, 1.04])
    assert [int(frame.image[0, 0]) for frame in frames] == scene.rendered[rendered_by_opening:]
    assert camera.counts.grabbed == pytest.approx(50, abs=1)
    assert camera.counts.dropped == 0


def test_numbers_count_the_frames_that_nobody_wanted_too(clock):
    camera = simulated(clock, CountingScene())
    camera.start()
    began = clock.now()
    camera.want(began + 0.3, began + 0.5)
    clock.sleep_until(began + 1.0)
    numbers = [frame.number for frame in camera.frames()]
    camera.close()
    assert numbers == list(range(numbers[0], numbers[0] + 5))
    assert numbers[0] == 7


def test_a_full_queue_drops_frames_and_says_how_many(clock):
    camera = simulated(clock, CountingScene(), queue_size=3)
    camera.start()
    camera.want_all()
    clock.sleep_until(clock.now() + 10.5 * PERIOD_S)
    kept = camera.frames()
    counts = camera.counts
    camera.close()
    assert len(kept) == 3
    assert counts.grabbed == 10
    assert counts.dropped == 7


def test_frames_taken_before_the_stop_can_be_fetched_after_it(clock):
    camera = simulated(clock, CountingScene())
    camera.start()
    camera.want_all()
    clock.sleep_until(clock.now() + 3.5 * PERIOD_S)
    camera.stop()
    clock.sleep_until(clock.now() + 1.0)
    assert len(camera.frames()) == 3
    assert camera.counts.grabbed == 3
    camera.close()


def test_each_start_begins_anew(clock):
    camera = simulated(clock, CountingScene())
    for frames in (2, 3):  # the second start falls into the middle of a period
        camera.start()
        camera.want_all()
        clock.sleep_until(clock.now() + 2.5 * PERIOD_S)
        assert [frame.number for frame in camera.frames()] == list(range(frames))
        assert camera.counts.grabbed == frames
        camera.stop()
    camera.start()
    clock.sleep_until(clock.now() + 1.0)
    assert camera.frames() == []
    camera.close()


def test_two_sessions_take_the_same_frames_at_the_same_times():
    def session() -> list[tuple[int, float]]:
        clock = VirtualClock()
        camera = simulated(clock, CountingScene())
        camera.start()
        camera.want(0.5, 0.9)
        clock.sleep_until(2.0)
        frames = [(frame.number, frame.time_s) for frame in camera.frames()]
        camera.close()
        return frames

    assert session() == session() != []


def test_a_camera_that_is_unplugged_says_so(clock):
    camera = simulated(clock, CountingScene(), CameraFaults(gone=from_frame(10)))
    camera.start()
    camera.want_all()
    clock.sleep_until(clock.now() + 1.0)
    assert len(camera.frames()) > 0
    with pytest.raises(DeviceError, match="stopped delivering"):
        camera.frames()
    camera.stop()
    with pytest.raises(DeviceError, match="stopped delivering"):
        camera.start()
    camera.close()


def test_a_second_start_is_refused(clock):
    camera = simulated(clock, CountingScene())
    camera.start()
    with pytest.raises(DeviceError, match="running already"):
        camera.start()
    camera.close()
