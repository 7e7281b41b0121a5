"""What devices report of themselves, and that a device that cannot is used all the same."""

from __future__ import annotations

import socket
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2
import pytest

from drivers.boards import BOARD_FAMILIES
from drivers.boards.conformance import connection_faults
from drivers.boards.ni.family import NiBoards
from drivers.cameras.sources import identity_of_source, without_password
from drivers.conformance import Checks
from drivers.identity import identities_of
from drivers.interfaces import DeviceError, DeviceIdentity
from drivers.positioners.manual import ManualStage
from sim_hardware.clock import VirtualClock
from tests.drivers.test_camera_iidc import GUID, library, needs_compiler  # noqa: F401 - a fixture
from tests.drivers.test_conformance import simulated_camera, zaber
from tests.drivers.test_dpm3 import Load, meter_on
from tests.drivers.test_stage_zaber import Person


def boards_of(ni_rig):
    settings = BOARD_FAMILIES.get("ni").settings()
    return NiBoards(settings, ni_rig.connection, ni_rig.clock)


@pytest.mark.slow
def test_ni_boards_report_product_serial_driver_and_that_they_are_simulated(ni_rig):
    drive, inputs = identities_of(boards_of(ni_rig))
    assert (drive.name, drive.maker, drive.product) == (
        "PCI6703", "National Instruments", "PCI-6703",
    )  # fmt: skip
    assert inputs.product == "PCI-6034E"
    assert all(len(board.serial) == 8 and int(board.serial, 16) for board in (drive, inputs))
    assert drive.serial != inputs.serial
    assert drive.driver.startswith("NI-DAQmx ")
    if ni_rig.server is not None:
        assert drive.is_simulated is inputs.is_simulated is True


def test_ni_boards_keep_the_contract_of_a_connection(simulated_ni):
    assert connection_faults(boards_of(simulated_ni), simulated_ni.clock) == []


def test_a_board_without_an_attribute_is_known_by_the_others(simulated_ni, monkeypatch):
    from nidaqmx.system import Device

    def refused(self):
        from nidaqmx.errors import DaqError

        raise DaqError("the property is not supported by the device", -200197)

    monkeypatch.setattr(Device, "serial_num", property(refused))
    drive, _ = identities_of(boards_of(simulated_ni))
    assert drive.serial == ""
    assert drive.product == "PCI-6703"
    assert drive.is_simulated is True


def test_a_camera_of_the_kernel_has_model_and_serial(tmp_path):
    device = tmp_path / "usb1" / "1-1" / "1-1:1.0"
    device.mkdir(parents=True)
    (device.parent / "serial").write_text("A1B2C3\n")
    (tmp_path / "v4l" / "video2").mkdir(parents=True)
    (tmp_path / "v4l" / "video2" / "name").write_text("HD Pro Webcam C920\n")
    (tmp_path / "v4l" / "video2" / "device").symlink_to(device)
    for source in (2, "/dev/video2"):
        found = identity_of_source(source, object(), tmp_path / "v4l")
        assert (found.product, found.serial) == ("HD Pro Webcam C920", "A1B2C3")


class Backend:
    def getBackendName(self):
        return "GSTREAMER"


def test_a_camera_that_only_opencv_knows_is_known_by_its_backend(monkeypatch):
    assert identity_of_source("videotestsrc ! appsink", Backend()).driver == ""  # none of OpenCV's
    monkeypatch.setattr(cv2, "VideoCapture", Backend)
    found = identity_of_source("videotestsrc ! appsink", Backend())
    assert found.driver == f"OpenCV {cv2.__version__} GSTREAMER"
    assert (found.product, found.serial, found.is_simulated) == ("", "", None)


def test_a_password_in_a_camera_address_is_not_part_of_its_name():
    assert without_password("rtsp://me:secret@cam/1") == "rtsp://cam/1"


class Named(BaseHTTPRequestHandler):
    """A camera's server that wants a password."""

    def do_HEAD(self):
        self.server.asked.append((self.path, self.headers["Authorization"]))
        self.send_response(401)
        self.end_headers()

    def version_string(self):
        return self.server.name

    def log_message(self, *_):
        pass


@pytest.fixture
def camera_server():
    """An HTTP server; `name` is what it calls itself."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), Named)
    server.asked, server.name = [], "MJPG-Streamer/0.2"
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    yield server
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.mark.parametrize(
    ("name", "product", "is_simulated"),
    [
        ("MJPG-Streamer/0.2", "MJPG-Streamer/0.2", None),
        ("labrig simulated camera", "labrig simulated camera", True),
        ("", "", None),
    ],
)
def test_a_camera_on_the_network_is_known_by_its_server(camera_server, name, product, is_simulated):
    camera_server.name = name
    source = f"http://me:secret@127.0.0.1:{camera_server.server_port}/video?size=1"
    found = identity_of_source(source, Backend())
    assert (found.product, found.is_simulated) == (product, is_simulated)
    assert camera_server.asked == [("/video?size=1", None)]  # no password to tell who it is


@pytest.mark.slow
def test_a_camera_on_the_network_that_does_not_tell_is_not_waited_for():
    with socket.create_server(("127.0.0.1", 0)) as silent:
        began_s = time.monotonic()
        found = identity_of_source(f"http://127.0.0.1:{silent.getsockname()[1]}/", Backend())
        assert time.monotonic() - began_s < 1.0
    assert (found.product, found.is_simulated) == ("", None)
    for source in ("http://127.0.0.1:9/", "http://[", "http://a:b/", "rtsp://127.0.0.1:9/1"):
        assert identity_of_source(source, Backend()).product == ""


@needs_compiler
@pytest.mark.system_package("gcc")
def test_a_firewire_camera_has_maker_model_and_guid(library):  # noqa: F811 - the fixture
    from drivers.cameras.capture_camera import CaptureCamera
    from drivers.cameras.iidc import IidcCapture

    clock = VirtualClock()
    camera = CaptureCamera("iidc:", clock, lambda _: IidcCapture(GUID, clock, library=library))
    camera.open()
    (found,) = identities_of(camera)
    camera.close()
    assert (found.maker, found.product) == ("Point Grey Research", "Dragonfly Express")
    assert found.serial == "00b09d0100112233"


def test_a_zaber_stage_has_serial_and_firmware():
    stage = zaber(VirtualClock())
    stage.open()
    (found,) = identities_of(stage)
    assert (found.maker, found.product, found.serial) == ("Zaber", "device 50081", "60001")
    assert found.driver == "firmware 6.28"


def test_a_meter_tells_its_product_and_a_manual_stage_nothing():
    meter = meter_on(VirtualClock(), Load())
    meter.open()
    assert identities_of(meter)[0].product == "DPM-3"
    assert identities_of(ManualStage(Person(answer=True))) == ()


class Silent:
    """A part of before there were identities."""


class Failing:
    def identities(self):
        raise DeviceError("it does not answer")


class Wrong:
    def identities(self):
        return ["PCI-6703"]


class TwoLines:
    def identities(self):
        return [DeviceIdentity(serial="1\n2")]


class Slow:
    def __init__(self, clock):
        self.clock = clock

    def identities(self):
        self.clock.sleep_until(self.clock.now() + 3.0)
        return ()


@pytest.mark.parametrize("device", [Silent(), Failing(), Wrong()])
def test_who_a_device_is_never_keeps_it_from_being_used(device):
    assert identities_of(device) == ()


def test_conformance_accepts_a_part_without_identity_and_finds_a_wrong_one():
    clock = VirtualClock()

    def faults(device):
        checks = Checks(clock)
        checks.identify(device)
        return " ".join(checks.faults)

    assert faults(Silent()) == ""
    assert faults(simulated_and_open(clock)) == ""
    assert "it does not answer" in faults(Failing())
    assert "no DeviceIdentity" in faults(Wrong())
    assert "not in lines of text" in faults(TwoLines())
    assert "took 3.00 s" in faults(Slow(clock))


def simulated_and_open(clock):
    camera = simulated_camera(clock)
    camera.open()
    return camera
