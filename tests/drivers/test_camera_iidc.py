"""The binding of libdc1394 against a small library of the same interface, compiled here."""

import ctypes
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from drivers.cameras.capture_camera import CaptureCamera
from drivers.cameras.iidc import IidcCapture, iidc_guid
from drivers.interfaces import DeviceError, DeviceNotFoundError

SOURCE = Path(__file__).with_name("fake_dc1394.c")
GUID = 0x00B09D0100112233
needs_compiler = pytest.mark.skipif(
    shutil.which("gcc") is None or sys.platform == "win32", reason="needs gcc"
)


class SteppingClock:
    """Waits by making time pass."""

    def __init__(self) -> None:
        self.time_s = 0.0

    def now(self) -> float:
        return self.time_s

    def sleep_until(self, when: float) -> None:
        self.time_s = max(self.time_s, when)

    def start_thread(self, target, name):
        target()
        return self

    def join(self, timeout=None) -> bool:
        return True


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("dc1394") / "libfake_dc1394.so"
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", path, SOURCE], check=True)
    return str(path)


def seen(library: str, name: str) -> int:
    return ctypes.c_int.in_dll(ctypes.CDLL(library), name).value


@needs_compiler
@pytest.mark.system_package("gcc")
def test_frames_come_without_padding_and_with_their_time(library):
    capture = IidcCapture(GUID, SteppingClock(), rate_hz=25.0, library=library)
    for number in range(5):
        assert capture.grab()
        good, image = capture.retrieve()
        assert good
        assert image.shape == (480, 640)
        assert np.all(image == 10 + number)  # the padding of a line holds 255
        assert capture.get(0) / 1e3 == pytest.approx(1.7e9 + 0.033333 * number, abs=1e-3)
    capture.release()
    capture.release()
    assert seen(library, "enqueued") == 5  # every buffer went back to the ring
    assert seen(library, "freed") == 2  # the camera and the bus, once each
    assert seen(library, "seen_transmission") == 0


@needs_compiler
@pytest.mark.system_package("gcc")
@pytest.mark.parametrize("set_s", [-3600, 1])
def test_frames_keep_their_distance_where_the_computers_clock_is_set(library, monkeypatch, set_s):
    """libdc1394 stamps frames with the time of day."""
    clock_set_s, time_of_day = ctypes.c_int.in_dll(ctypes.CDLL(library), "clock_set_s"), time.time
    monkeypatch.setattr(time, "time", lambda: time_of_day() + clock_set_s.value)
    capture = IidcCapture(GUID, SteppingClock(), library=library)
    stamps_s = []
    try:
        for number in range(5):
            clock_set_s.value = set_s if number > 2 else 0
            assert capture.grab()
            stamps_s.append(capture.get(0) / 1e3)
    finally:
        clock_set_s.value = 0
        capture.release()
    assert np.diff(stamps_s) == pytest.approx(0.033333, abs=1e-3)


@needs_compiler
@pytest.mark.system_package("gcc")
def test_the_camera_is_set_to_grey_and_to_the_next_rate_it_has(library):
    IidcCapture(GUID, SteppingClock(), rate_hz=25.0, library=library).release()
    assert seen(library, "seen_mode") == 69  # 640 x 480, 8 bit grey
    assert seen(library, "seen_rate") == 36  # 30 frames/s
    assert seen(library, "seen_speed") == 3  # 800 Mbit/s


@needs_compiler
@pytest.mark.system_package("gcc")
def test_an_old_bus_is_used_at_its_own_speed(library):
    old_bus = ctypes.c_int.in_dll(ctypes.CDLL(library), "old_bus")
    old_bus.value = 1
    try:
        IidcCapture(GUID, SteppingClock(), library=library).release()
    finally:
        old_bus.value = 0
    assert seen(library, "seen_speed") == 2  # 400 Mbit/s


@needs_compiler
@pytest.mark.system_package("gcc")
def test_a_camera_that_stops_is_waited_for_two_seconds_only(library):
    clock = SteppingClock()
    capture = IidcCapture(GUID, clock, library=library)
    for _ in range(5):
        capture.grab()
    began = clock.now()
    assert not capture.grab()
    assert 2.0 <= clock.now() - began < 2.1
    assert capture.retrieve() == (False, None)
    capture.release()


@needs_compiler
@pytest.mark.system_package("gcc")
def test_a_camera_that_is_not_on_the_bus_is_refused_with_those_that_are(library):
    with pytest.raises(DeviceNotFoundError, match="iidc:00b09d0100aabbcc, iidc:00b09d0100112233"):
        IidcCapture(1, SteppingClock(), library=library)
    assert seen(library, "freed") == 1  # the bus


@needs_compiler
@pytest.mark.system_package("gcc")
def test_a_camera_that_another_program_uses_is_said_so(library):
    with pytest.raises(DeviceNotFoundError, match="another program uses it"):
        IidcCapture(None, SteppingClock(), library=library)  # the first on the bus


@needs_compiler
@pytest.mark.system_package("gcc")
def test_the_driver_reads_it_like_any_other_camera(library):
    clock = SteppingClock()
    camera = CaptureCamera(
        "iidc:00b09d0100112233", clock, lambda _: IidcCapture(GUID, clock, library=library)
    )
    camera.open()
    assert camera.frame_shape == (480, 640)
    assert camera.dtype == np.uint8
    with pytest.raises(DeviceError, match="stopped delivering"):
        camera.start()  # its five frames are over
    camera.close()


def test_a_missing_library_tells_what_to_install():
    with pytest.raises(DeviceNotFoundError, match=r"libdc1394.*install it"):
        IidcCapture(GUID, SteppingClock(), library="/nowhere/libdc1394.so")


def test_a_library_that_is_another_one_is_refused():
    with pytest.raises(DeviceNotFoundError, match="cannot be loaded"):
        IidcCapture(GUID, SteppingClock(), library=ctypes.util.find_library("c"))


@pytest.mark.parametrize(
    ("source", "guid"),
    [("iidc:00b09d0100112233", GUID), ("iidc:0x00b09d0100112233", GUID), ("iidc:", None)],
)
def test_a_guid_is_read(source, guid):
    assert iidc_guid(source) == guid


def test_a_guid_that_is_none_is_refused():
    with pytest.raises(DeviceNotFoundError, match="16 hexadecimal"):
        iidc_guid("iidc:firefly")
