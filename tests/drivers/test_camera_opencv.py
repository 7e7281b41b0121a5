"""The camera driver on real captures: a network stream, a file, and captures that fail."""

import socket
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from drivers.cameras import capture as camera_capture
from drivers.cameras.capture import CONVERT_RGB, FPS, HEIGHT, WIDTH
from drivers.cameras.capture_camera import CaptureCamera
from drivers.interfaces import (
    Camera,
    DeviceError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    RealClock,
)
from sim_hardware.camera import CameraFaults, CameraServer, SimulatedCapture, from_frame

ROWS, COLUMNS = 48, 64


class NumberedScene:
    """Every frame is one grey: its number."""

    frame_shape = (ROWS, COLUMNS)
    frame_rate_hz = 100.0

    def image(self, when: float, number: int) -> np.ndarray:
        return np.full(self.frame_shape, number % 251, dtype=np.uint8)


class Capture:
    """A capture that delivers given pictures, then ends."""

    def __init__(self, raw: list[np.ndarray], converted: np.ndarray | None = None, size=None):
        self.raw, self.converted = raw, converted
        self.size = size or (ROWS, COLUMNS)
        self.properties: dict[int, float] = {FPS: 100.0}
        self.released = False
        self.opens = True

    def isOpened(self) -> bool:
        return self.opens

    def set(self, prop: int, value: float) -> bool:
        self.properties[prop] = value
        return True

    def get(self, prop: int) -> float:
        size = {HEIGHT: float(self.size[0]), WIDTH: float(self.size[1])}
        return size.get(prop, self.properties.get(prop, 0.0))

    def grab(self) -> bool:
        time_to_end = not self.raw
        self.current = None if time_to_end else self.raw.pop(0)
        return not time_to_end

    def retrieve(self):
        if self.properties.get(CONVERT_RGB) and self.converted is not None:
            return True, self.converted
        return self.current is not None, self.current

    def read(self):
        self.grab()
        return self.retrieve()

    def release(self) -> None:
        self.released = True


def grey(value: int, dtype=np.uint8, shape=(ROWS, COLUMNS)) -> np.ndarray:
    return np.full(shape, value, dtype=dtype)


def opened(*pictures: np.ndarray, **kwargs) -> CaptureCamera:
    camera = CaptureCamera("fake", RealClock(), lambda _: Capture(list(pictures), **kwargs))
    camera.open()
    return camera


def wait_for(found, seconds: float = 3.0):
    """Poll until `found()` is true or an exception comes."""
    clock = RealClock()
    until = clock.now() + seconds
    while clock.now() < until:
        if result := found():
            return result
        clock.sleep_until(clock.now() + 0.005)
    pytest.fail("waited in vain")


@pytest.fixture
def server():
    stream = CameraServer(NumberedScene(), RealClock())
    yield stream
    stream.stop()


# it is paced by the clock: beside other work frames come late
@pytest.mark.alone
def test_a_network_stream_is_read_grey_and_undistorted(server):
    camera = CaptureCamera(server.url, RealClock())
    camera.open()
    try:
        assert isinstance(camera, Camera)
        assert camera.frame_shape == (ROWS, COLUMNS)
        assert camera.dtype == np.uint8
        camera.start()
        camera.want_all()
        frames: list = []
        wait_for(lambda: frames.extend(camera.frames()) or len(frames) >= 10)
        values = [int(frame.image[0, 0]) for frame in frames]
        assert all(frame.image.min() == frame.image.max() for frame in frames)
        assert np.all(np.diff(values) >= 1)
        times = [frame.time_s for frame in frames]
        assert np.all(np.diff(times) > 0.0)
        assert np.median(np.diff(times)) == pytest.approx(0.01, rel=0.3)
    finally:
        camera.close()
        camera.close()


@pytest.mark.slow
def test_after_a_pause_no_stale_frame_is_served(server):
    """A session pauses for minutes between runs, while the stream goes on."""
    clock = RealClock()
    camera = CaptureCamera(server.url, clock)
    camera.open()
    try:
        camera.start()
        camera.want_all()
        before = wait_for(camera.frames)[-1]
        camera.stop()
        clock.sleep_until(clock.now() + 0.5)
        camera.start()
        camera.want_all()
        after = wait_for(camera.frames)[0]
        passed = (int(after.image[0, 0]) - int(before.image[0, 0])) % 251
        assert passed == pytest.approx((after.time_s - before.time_s) * 100.0, abs=6)
        assert after.number == 0
    finally:
        camera.close()


def test_a_url_that_nobody_serves_is_refused_in_bounded_time():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        url = f"http://127.0.0.1:{probe.getsockname()[1]}/"
    began = time.perf_counter()
    with pytest.raises(DeviceNotFoundError, match="nobody sends an image there"):
        CaptureCamera(url, RealClock()).open()
    assert time.perf_counter() - began < 6.0


@pytest.mark.slow
def test_a_url_that_accepts_and_stays_silent_is_refused_in_bounded_time(monkeypatch):
    monkeypatch.setattr(camera_capture, "OPEN_TIMEOUT_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        began = time.perf_counter()
        with pytest.raises(DeviceNotFoundError):
            CaptureCamera(f"http://127.0.0.1:{silent.getsockname()[1]}/", RealClock()).open()
        assert time.perf_counter() - began < 1.5


def test_a_server_that_goes_away_is_noticed(server, capfd):
    camera = CaptureCamera(server.url, RealClock(), stall_s=1.0)
    camera.open()
    try:
        camera.start()
        camera.want_all()
        wait_for(camera.frames)
        server.stop()
        with pytest.raises(DeviceError, match=r"stopped delivering|no frame for"):
            wait_for(lambda: camera.frames() and False, seconds=5.0)
    finally:
        camera.close()
    assert capfd.readouterr().err == ""  # what OpenCV and FFmpeg write by themselves helps nobody


@pytest.mark.slow
def test_a_camera_that_hangs_is_noticed_before_its_own_time_out():
    faults = CameraFaults(drop=from_frame(5))
    clock = RealClock()
    camera = CaptureCamera(
        "simulated",
        clock,
        lambda _: SimulatedCapture(NumberedScene(), clock, faults=faults),
        stall_s=0.2,
    )
    camera.open()
    try:
        camera.start()
        camera.want_all()
        with pytest.raises(DeviceTimeoutError, match="no frame for"):
            wait_for(lambda: camera.frames() and False)
    finally:
        camera.close()


@pytest.mark.slow
def test_a_file_is_played_at_its_own_rate(tmp_path: Path):
    path = tmp_path / "strip.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 50.0, (COLUMNS, ROWS))
    for value in range(20):
        writer.write(cv2.cvtColor(grey(10 * value), cv2.COLOR_GRAY2BGR))
    writer.release()
    camera = CaptureCamera(str(path), RealClock())
    camera.open()
    camera.start()
    camera.want_all()
    frames: list = []
    with pytest.raises(DeviceError, match="the stream has ended"):
        wait_for(lambda: frames.extend(camera.frames()))
    camera.close()
    assert len(frames) >= 18  # the thread began with the first one before `start`
    assert [int(frame.image.mean()) for frame in frames] == pytest.approx(
        [10 * frame.number + 10 * (20 - len(frames)) for frame in frames], abs=3
    )
    assert np.median(np.diff([frame.time_s for frame in frames])) == pytest.approx(0.02, abs=0.004)


def test_a_file_without_video_is_refused(tmp_path: Path):
    path = tmp_path / "notes.avi"
    path.write_text("no video")
    with pytest.raises(DeviceNotFoundError, match="no video that can be read"):
        CaptureCamera(str(path), RealClock()).open()


@pytest.mark.parametrize("source", [97, "/dev/video-of-nobody"])
def test_a_camera_that_is_not_there_is_refused(source):
    with pytest.raises(DeviceNotFoundError, match=rf"source = {source}"):
        CaptureCamera(source, RealClock()).open()


def test_colour_is_made_grey():
    colour = np.zeros((ROWS, COLUMNS, 3), dtype=np.uint8)
    colour[:] = (10, 200, 60)
    camera = opened(colour)
    assert camera.frame_shape == (ROWS, COLUMNS)
    camera.close()


def test_sixteen_bit_frames_stay_sixteen_bit():
    camera = opened(grey(40_000, np.uint16))
    assert camera.dtype == np.uint16
    camera.close()


def test_a_camera_that_sends_compressed_bytes_is_decoded_by_opencv():
    raw_jpeg = np.zeros((1, 5000), dtype=np.uint8)
    camera = opened(raw_jpeg, raw_jpeg, converted=np.zeros((ROWS, COLUMNS, 3), dtype=np.uint8))
    assert camera.frame_shape == (ROWS, COLUMNS)
    camera.close()


def test_pixels_of_another_type_are_refused():
    with pytest.raises(DeviceError, match="float32 pixels"):
        opened(grey(1, np.float32))


@pytest.mark.slow
def test_a_frame_of_another_size_ends_the_delivery_with_its_reason():
    clock = RealClock()
    faults = CameraFaults(wrong_size=from_frame(20))
    camera = CaptureCamera(
        "simulated", clock, lambda _: SimulatedCapture(NumberedScene(), clock, faults=faults)
    )
    camera.open()
    try:
        camera.start()
        camera.want_all()
        with pytest.raises(DeviceError, match="sent a frame of 32 x 24 uint8 after frames of 64"):
            wait_for(lambda: camera.frames() and False)
    finally:
        camera.close()


@pytest.mark.parametrize("end", [SystemExit(3), KeyboardInterrupt()])
def test_a_capture_that_ends_the_program_ends_the_delivery_with_its_reason(end):
    class Leaving(Capture):
        def grab(self) -> bool:
            if not self.raw:
                raise end
            return super().grab()

    pictures = [grey(value) for value in range(5)]
    camera = CaptureCamera("fake", RealClock(), lambda _: Leaving(pictures))
    camera.open()
    try:
        said = f"has stopped delivering: {type(end).__name__}"
        with pytest.raises(DeviceError, match=said) as told:
            wait_for(camera.start)
        assert told.value.__cause__ is end
    finally:
        camera.close()


class Bare(Capture):
    """A capture that returns the image alone."""

    def read(self):
        return super().read()[1]


class Lacking(Capture):
    get = None


@pytest.mark.parametrize(
    ("capture", "said"),
    [
        (Bare, r"of camera fake returned ndarray from read, not \(True, image\)"),
        (Lacking, r"of camera fake \(Lacking\) has no get"),
        (lambda _: None, r"of camera fake \(NoneType\) has no isOpened, grab, retrieve, read, get"),
    ],
)
def test_a_capture_that_is_none_is_told_what_it_lacks(capture, said):
    pictures = [np.full((4, 6), 7, np.uint8)] * 3
    with pytest.raises(DeviceError, match=said):
        CaptureCamera("fake", RealClock(), lambda _: capture(pictures)).open()


def test_a_capture_that_opens_but_sends_nothing_is_refused_and_released():
    capture = Capture([])
    with pytest.raises(DeviceNotFoundError, match="sends no frame"):
        CaptureCamera("fake", RealClock(), lambda _: capture).open()
    assert capture.released


def test_a_camera_that_is_not_open_says_so():
    camera = CaptureCamera(0, RealClock())
    with pytest.raises(DeviceError, match="not open"):
        camera.start()
    camera.stop()
    camera.close()
