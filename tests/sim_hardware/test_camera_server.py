"""The simulated camera on the network, read by OpenCV in real time."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator

import cv2
import numpy as np
import pytest

from drivers.interfaces import RealClock
from sim_hardware.camera import CameraFaults, CameraServer, from_frame
from sim_hardware.optics import read_marker, write_marker

pytestmark = pytest.mark.slow


class NoiseScene:
    """Pictures that no lossy coding survives, with the frame number and time written in."""

    frame_shape = (480, 640)

    def __init__(self, frame_rate_hz: float = 100.0) -> None:
        self.frame_rate_hz = frame_rate_hz
        self.rendered = 0

    def image(self, when: float, number: int) -> np.ndarray:
        self.rendered += 1
        image = np.random.default_rng(number).integers(0, 256, self.frame_shape, dtype=np.uint8)
        write_marker(image, number, when)
        return image


Serve = Callable[..., CameraServer]


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Start servers; afterwards stop them and see that no thread is left."""
    before = set(threading.enumerate())
    servers: list[CameraServer] = []

    def start(scene: NoiseScene, **keywords) -> CameraServer:
        servers.append(CameraServer(scene, RealClock(), **keywords))
        return servers[-1]

    yield start
    for server in servers:
        server.stop()
        server.stop()
    assert set(threading.enumerate()) <= before


def open_grey(server: CameraServer) -> cv2.VideoCapture:
    limits = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, 3000, cv2.CAP_PROP_READ_TIMEOUT_MSEC, 1000]
    capture = cv2.VideoCapture(server.url, cv2.CAP_FFMPEG, limits)
    assert capture.isOpened()
    capture.set(cv2.CAP_PROP_CONVERT_RGB, 0)
    return capture


def read_numbers(capture: cv2.VideoCapture, count: int) -> list[int]:
    return [read_marker(capture.read()[1])[0] for _ in range(count)]


def test_opencv_reads_every_frame_byte_by_byte(serve: Serve) -> None:
    scene = NoiseScene()
    capture = open_grey(serve(scene))
    seen = []
    for _ in range(60):
        good, image = capture.read()
        assert good
        number, when = read_marker(image)
        seen.append(number)
        assert image.shape == (480, 640)
        assert np.array_equal(image, scene.image(when, number))
    capture.release()
    assert seen == list(range(seen[0], seen[0] + 60))


def test_frames_arrive_in_real_time(serve: Serve) -> None:
    clock = RealClock()
    capture = open_grey(serve(NoiseScene(50.0)))
    late = []
    for _ in range(50):
        capture.grab()
        arrived = clock.now()
        late.append(arrived - read_marker(capture.retrieve()[1])[1])
    capture.release()
    # The first frames have waited while OpenCV was opening the stream.
    assert 0 < np.median(late[10:]) < 0.015


def test_several_clients_see_the_same_frames_rendered_once(serve: Serve) -> None:
    scene = NoiseScene(50.0)
    server = serve(scene)
    captures = [open_grey(server) for _ in range(3)]
    rendered = scene.rendered
    seen = [set(read_numbers(capture, 20)) for capture in captures]
    assert seen[0] & seen[1] & seen[2]
    assert scene.rendered - rendered <= max(map(max, seen)) + 2
    for capture in captures:
        capture.release()


def test_nothing_is_rendered_while_nobody_watches(serve: Serve) -> None:
    scene = NoiseScene()
    server = serve(scene)
    time.sleep(0.1)  # noqa: TID251 - the server runs on the real clock
    assert scene.rendered == 0
    capture = open_grey(server)
    assert read_numbers(capture, 1)[0] >= 9
    capture.release()


def test_a_slow_client_misses_frames_and_gets_fresh_ones(serve: Serve) -> None:
    clock = RealClock()
    capture = open_grey(serve(NoiseScene()))
    first = read_numbers(capture, 3)[-1]
    clock.sleep_until(clock.now() + 1.5)
    seen = read_numbers(capture, 60)
    assert max(np.diff(seen)) > 20  # skipped, not queued
    assert seen[-1] - first >= 150
    capture.release()


def test_a_client_that_sends_nothing_does_not_disturb_the_others(serve: Serve) -> None:
    server = serve(NoiseScene())
    host, port = server.url.removeprefix("http://").rstrip("/").split(":")
    with socket.create_connection((host, int(port))):
        capture = open_grey(server)
        assert len(read_numbers(capture, 5)) == 5
        capture.release()


def test_a_taken_port_is_an_error(serve: Serve) -> None:
    server = serve(NoiseScene())
    port = int(server.url.rstrip("/").rsplit(":", 1)[1])
    with pytest.raises(OSError, match=r"[Aa]ddress"):
        CameraServer(NoiseScene(), RealClock(), port)


def test_an_unplugged_camera_ends_the_stream(serve: Serve) -> None:
    server = serve(NoiseScene())
    capture = open_grey(server)
    now = read_numbers(capture, 3)[-1]
    server.faults.gone = from_frame(now + 10)
    start = time.perf_counter()
    while capture.grab():
        assert time.perf_counter() - start < 3
    capture.release()


def test_dropped_frames_are_missing_and_a_hung_camera_times_out(serve: Serve) -> None:
    server = serve(NoiseScene(), faults=CameraFaults(drop=range(1, 10_000, 2)))
    capture = open_grey(server)
    seen = read_numbers(capture, 10)
    assert all(number % 2 == 0 for number in seen)
    server.faults.drop = from_frame(0)
    start = time.perf_counter()
    while capture.grab():
        assert time.perf_counter() - start < 4
    assert 0.8 < time.perf_counter() - start < 4
    capture.release()


def test_a_new_size_needs_a_new_connection(serve: Serve) -> None:
    server = serve(NoiseScene())
    capture = open_grey(server)
    read_numbers(capture, 3)
    server.faults.wrong_size = from_frame(0)
    start = time.perf_counter()
    while capture.grab():
        assert time.perf_counter() - start < 3
    capture.release()
    again = open_grey(server)
    assert again.read()[1].shape == (240, 320)
    again.release()
