"""Real, simulated and fake devices keep one contract; one that breaks it is found."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.boards import BOARD_FAMILIES
from drivers.boards.conformance import (
    family_faults,
    interlock_faults,
    output_faults,
    rescue_faults,
    signal_faults,
)
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.interlock import NiInterlock
from drivers.boards.ni.rescue import NiRescue, OutputPlace
from drivers.boards.read_back_conformance import read_back_faults
from drivers.cameras import CAMERAS
from drivers.cameras.capture_camera import CaptureCamera
from drivers.cameras.conformance import camera_faults
from drivers.cameras.iidc import IidcCapture
from drivers.force_sensors import FORCE_SENSORS
from drivers.force_sensors.conformance import force_sensor_faults
from drivers.force_sensors.dpm3 import Dpm3Meter
from drivers.force_sensors.metered_input import MeteredInput
from drivers.interfaces import DeviceError, DeviceTimeoutError, Frame, RealClock
from drivers.positioners import POSITIONERS
from drivers.positioners.conformance import positioner_faults
from drivers.positioners.manual import ManualStage
from drivers.positioners.zaber import ZaberStage
from sim_hardware import serial_devices as simulated
from sim_hardware.camera import SimulatedCapture
from sim_hardware.clock import VirtualClock
from tests.drivers.test_camera_virtual import CountingScene
from tests.drivers.test_dpm3 import Load, meter_on
from tests.drivers.test_stage_zaber import RADIUS_M, Arc, Person

FOLDERS = (BOARD_FAMILIES, CAMERAS, FORCE_SENSORS, POSITIONERS)


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.what)
def test_every_part_of_a_folder_is_a_kind_of_its_own_name(folder):
    assert folder.parts()
    for name, part in folder.parts().items():
        assert folder.faults(part.part) == []
        assert part.part.kind == name


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.what)
def test_what_is_no_kind_is_said_so(folder):
    assert "it is of type object, not a" in folder.faults(object())[0]


# ---------------------------------------------------------------------------------------- cameras


def simulated_camera(clock, kind=CaptureCamera, scene=CountingScene):
    return kind("simulated", clock, lambda _: SimulatedCapture(scene(), clock))


def test_the_simulated_camera_keeps_the_contract():
    clock = VirtualClock()
    assert camera_faults(simulated_camera(clock), clock) == []


@pytest.mark.skipif(
    shutil.which("gcc") is None or sys.platform == "win32", reason="needs gcc for libdc1394's twin"
)
def test_a_firewire_camera_keeps_the_contract(tmp_path: Path):
    library = str(tmp_path / "libfake_dc1394.so")
    source = Path(__file__).with_name("fake_dc1394.c")
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", library, source], check=True)
    ctypes.c_int.in_dll(ctypes.CDLL(library), "most_frames").value = 100_000
    clock = VirtualClock()
    guid = 0x00B09D0100112233
    camera = CaptureCamera("iidc:", clock, lambda _: IidcCapture(guid, clock, library=library))
    assert camera_faults(camera, clock, watch_s=0.2) == []


class WrongType(CaptureCamera):
    """Says that its pixels have 16 bit."""

    dtype = np.dtype(np.uint16)


class Blocking(CaptureCamera):
    """Waits for the next frame when it is asked for those that have come."""

    def frames(self) -> list[Frame]:
        self._clock.sleep_until(self._clock.now() + 0.5)
        return super().frames()


class Raising(CaptureCamera):
    """Raises an error of its own making when it runs already."""

    def start(self) -> None:
        if self._running:
            raise RuntimeError("busy")
        super().start()


class Eager(CaptureCamera):
    """Keeps frames that nobody wanted."""

    def want(self, from_s: float, to_s: float) -> None:
        self.want_all()


class Counting(CaptureCamera):
    """Numbers the frames that it hands over, not those that came."""

    def frames(self) -> list[Frame]:
        return [
            Frame(number=number, time_s=frame.time_s, device_time_s=None, image=frame.image)
            for number, frame in enumerate(super().frames())
        ]


class OneBuffer(CaptureCamera):
    """Hands over the same memory with each frame."""

    def frames(self) -> list[Frame]:
        found = super().frames()
        return [
            Frame(number=f.number, time_s=f.time_s, device_time_s=None, image=found[0].image)
            for f in found
        ]


class Dark(CaptureCamera):
    """Sends nothing."""

    def frames(self) -> list[Frame]:
        super().frames()
        return []


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (WrongType, "an image is (4, 6) uint8; frame_shape and dtype are (4, 6) uint16"),
        (Blocking, "frames took 0.50 s; at most 0.3 s are allowed"),
        (Raising, "raised RuntimeError (busy), which is no DeviceError"),
        (Eager, "frames came that nobody wanted"),
        (Counting, "frames that nobody wanted do not count as frames"),
        (OneBuffer, "share their memory"),
        (Dark, "0 frames came"),
    ],
)
def test_a_camera_that_breaks_the_contract_is_found(kind, said):
    clock = VirtualClock()
    found = camera_faults(simulated_camera(clock, kind), clock)
    assert any(said in fault for fault in found), found


class NeverWaiting(SimulatedCapture):
    """Hands over a frame whenever it is asked for one."""

    def grab(self) -> bool:
        self._clock.sleep_until(self._clock.now() + 5e-3)
        self._number = 0 if self._number is None else self._number + 1
        return True


class OtherSize(SimulatedCapture):
    """States another size than that of its frames."""

    def get(self, propId: int) -> float:
        return 100.0 if propId in (3, 4) else super().get(propId)


def camera_on(capture, clock):
    return CaptureCamera("simulated", clock, lambda _: capture(CountingScene(), clock))


def test_a_camera_that_never_waits_for_a_frame_is_found():
    clock = VirtualClock()
    found = camera_faults(camera_on(NeverWaiting, clock), clock)
    assert any("frames came in 1 s" in f and "25 a second were asked for" in f for f in found), (
        found
    )


def test_the_rate_that_a_camera_was_made_for_counts_where_it_states_none():
    clock = VirtualClock()
    camera = simulated_camera(clock)
    assert camera_faults(camera, clock, rate_hz=25.0) == []
    found = camera_faults(simulated_camera(clock), clock, rate_hz=5.0)
    assert any("5 a second were asked for" in fault for fault in found), found


def test_a_capture_that_states_another_size_than_its_frames_have_is_found():
    clock = VirtualClock()
    (fault,) = camera_faults(camera_on(OtherSize, clock), clock)
    assert fault == "it states 100 x 100 pixels (width x height), and its frames have 6 x 4"


def test_what_lacks_a_method_of_a_device_is_told_which():
    clock = VirtualClock()
    methods = "start, want, want_all, frames, stop, fire"
    assert camera_faults(Opening(), clock) == [f"it has no method {methods}"]
    assert force_sensor_faults(Opening(), clock) == ["it has no method read_force, tare"]
    assert positioner_faults(Opening(), clock) == ["it has no method move_to, position"]


class Opening:
    """It can be opened and closed."""

    def open(self) -> None:
        """Open it."""

    def close(self) -> None:
        """Close it."""


# ------------------------------------------------------------------------------------- positioners


def zaber(clock, kind=ZaberStage):
    device = simulated.SimulatedZaberStage(Arc(), clock, homed=True)

    def port(name, **settings):
        return simulated.InMemorySerial(device, clock, port=name, **settings)

    return kind("COM2", clock, RADIUS_M, serial_factory=port)


def test_a_zaber_stage_keeps_the_contract():
    clock = VirtualClock()
    assert positioner_faults(zaber(clock), clock, outside_m=10.0) == []


def test_a_stage_moved_by_hand_keeps_the_contract():
    assert positioner_faults(ManualStage(Person(answer=True)), RealClock()) == []


class Overstated(ZaberStage):
    """States a travel that it does not keep."""

    def travel_m(self):
        return 0.0, 0.015


def test_a_stage_that_goes_beyond_the_travel_it_states_is_found():
    clock = VirtualClock()
    assert "move_to(0.016) was not refused with LimitError" in " ".join(
        positioner_faults(zaber(clock, Overstated), clock)
    )


class Sloppy(ZaberStage):
    """Believes that it has arrived."""

    def position(self) -> float | None:
        return 0.0


class Clamped:
    """A stage that goes to the end of its travel where it is sent beyond it."""

    def __init__(self) -> None:
        self._at_m = 0.0

    def open(self) -> None: ...
    def close(self) -> None: ...

    def move_to(self, position_m: float) -> bool:
        self._at_m = min(position_m, 0.06)
        return True

    def position(self) -> float | None:
        return self._at_m


def test_a_stage_that_does_not_refuse_is_told_once():
    found = positioner_faults(Clamped(), VirtualClock(), outside_m=0.2)
    assert "move_to(0.2) was not refused with LimitError" in found
    assert not any("was refused, but it moved" in text for text in found)


def test_a_stage_that_reports_another_position_is_found():
    clock = VirtualClock()
    assert "after move_to(0.01) position is 0" in positioner_faults(zaber(clock, Sloppy), clock)


class InMillimetres(ZaberStage):
    """States its travel in mm."""

    def travel_m(self):
        return 0.0, 60.0


def test_a_travel_in_another_unit_is_found_and_nothing_is_moved_to_its_ends():
    clock = VirtualClock()
    assert positioner_faults(zaber(clock, InMillimetres), clock) == [
        "its travel is 0 to 60 m: is it in mm?"
    ]


class OneNumber(ZaberStage):
    """Its travel is a length."""

    def travel_m(self):
        return 0.06


def test_a_travel_that_is_no_two_numbers_is_found():
    clock = VirtualClock()
    found = positioner_faults(zaber(clock, OneNumber), clock)
    assert "travel_m returned 0.06, not the lower and the upper end in m" in found


class Silent(ZaberStage):
    """Its cable was pulled out."""

    def move_to(self, position_m: float) -> bool:
        self._clock.sleep_until(self._clock.now() + 10.0)
        raise DeviceTimeoutError("the stage does not answer; check its cable")

    def position(self) -> float | None:
        self.move_to(0.0)
        return None


def test_a_stage_that_does_not_answer_is_asked_once():
    clock = VirtualClock()
    began_s = clock.now()
    assert positioner_faults(zaber(clock, Silent), clock) == [
        "move_to(0) raised DeviceTimeoutError: the stage does not answer; check its cable"
    ]
    assert clock.now() - began_s < 15.0


class Failing(ZaberStage):
    """Fails in each move."""

    def move_to(self, position_m: float) -> bool:
        raise DeviceError("the stage is stuck")


def test_of_a_move_that_failed_nothing_else_is_judged():
    clock = VirtualClock()
    found = positioner_faults(zaber(clock, Failing), clock)
    assert found[0] == "move_to(0) raised DeviceError: the stage is stuck"
    assert not any("returned" in fault or "after move_to" in fault for fault in found)


# ----------------------------------------------------------------------------------- force sensors


def test_a_dpm3_meter_keeps_the_contract():
    clock = VirtualClock()
    assert force_sensor_faults(meter_on(clock, Load(0.02)), clock) == []


class InGrams(Dpm3Meter):
    """Reports what it displays."""

    def read_force(self) -> float:
        return super().read_force() / 9.80665e-3


def test_a_sensor_of_another_unit_is_found():
    clock = VirtualClock()
    device = simulated.SimulatedDpm3Meter(Load(0.02), clock, noise_N=0.0)

    def port(name, **settings):
        return simulated.InMemorySerial(device, clock, port=name, **settings)

    found = force_sensor_faults(InGrams("COM1", serial_factory=port), clock)
    assert any("the range is 0.98 N (5 times)" in fault for fault in found)


class Stuck(Dpm3Meter):
    """Fails in each reading."""

    error: type[DeviceError] = DeviceError
    is_open = False

    def open(self) -> None:
        super().open()
        self.is_open = True

    def read_force(self) -> float:
        force_N = super().read_force()
        if self.is_open:
            raise self.error("the meter shows no number")
        return force_N


class Hung:
    """A sensor that answers nothing while it is open, and waits for ever."""

    range_N = 1.0
    is_open = False

    def open(self):
        self.is_open = True

    def read_force(self):
        if not self.is_open:
            raise DeviceError("it is not open")
        threading.Event().wait(20.0)

    def tare(self):
        pass

    def close(self):
        self.is_open = False


def test_a_sensor_whose_call_never_returns_is_told_and_asked_once(monkeypatch):
    monkeypatch.setattr("drivers.conformance.BLOCKED_S", 0.2)
    monkeypatch.setattr("drivers.force_sensors.conformance.READ_S", 0.2)
    found = force_sensor_faults(Hung(), RealClock())
    assert found == ["read_force has not returned in 0.4 s: it blocks"]


class Mute(Stuck):
    """It is silent after it was opened."""

    error = DeviceTimeoutError


class Slow:
    """A sensor that takes its time, and returns what it is made with."""

    range_N = 1.0

    def __init__(self, clock, force_N, takes_s: float) -> None:
        self._clock, self._force_N, self._takes_s, self._is_open = clock, force_N, takes_s, False

    def open(self) -> None:
        self._is_open = True

    def read_force(self):
        if not self._is_open:
            raise DeviceError("open the sensor first")
        self._clock.sleep_until(self._clock.now() + self._takes_s)
        return self._force_N

    def tare(self) -> None:
        self._force_N = type(self._force_N)(0)

    def close(self) -> None:
        self._is_open = False


def test_a_sensor_that_reads_too_seldom_or_returns_no_float_is_found():
    clock = VirtualClock()
    assert force_sensor_faults(Slow(clock, 0.5, 0.1), clock) == []
    assert force_sensor_faults(Slow(clock, 0.5, 0.6), clock) == [
        (
            "read_force takes 0.60 s; the force between two readings is a straight line, so "
            "0.25 s is the most"
        )
    ]
    assert force_sensor_faults(Slow(clock, 0, 0.1), clock) == [
        "read_force returned 0; a float in N is needed (5 times)"
    ]


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (Stuck, "read_force raised DeviceError: the meter shows no number (6 times)"),
        (Mute, "read_force raised DeviceTimeoutError: the meter shows no number"),
    ],
)
def test_each_sentence_about_a_sensor_is_said_once_and_a_silent_one_is_asked_once(kind, said):
    clock = VirtualClock()
    device = simulated.SimulatedDpm3Meter(Load(0.02), clock, noise_N=0.0)

    def port(name, **settings):
        return simulated.InMemorySerial(device, clock, port=name, **settings)

    assert force_sensor_faults(kind("COM1", serial_factory=port), clock) == [said]


# ------------------------------------------------------------------------------------------ boards


@pytest.mark.slow
def test_ni_boards_keep_the_contract(ni_rig):
    clock = ni_rig.clock
    output = NiVoltageOutput(ni_rig.connection, clock, ni_rig.drive, 0.25)
    assert output_faults(output, 0.25, clock) == []
    assert signal_faults(ni_rig.signals(), clock) == []


def read_back_of(rig, **changed) -> list[str]:
    output, signals = rig.output(), rig.signals()
    output.open()
    signals.open()
    for name, value in changed.items():
        setattr(signals, name, value(signals))
    try:
        return read_back_faults(output, signals, 0.2, rig.clock)
    finally:
        signals.close()
        output.close()


def test_the_read_back_of_ni_boards_shows_an_edge_when_it_was_written(simulated_ni):
    assert read_back_of(simulated_ni) == []


def test_a_read_back_whose_samples_are_labelled_late_is_found(simulated_ni):
    def late(signals):
        start = signals.start
        return lambda: replace(started := start(), start_s=started.start_s + 0.08)

    (fault,) = read_back_of(simulated_ni, start=late)
    assert "drive shows a write 80 ms after it, by the samples' clock; 50 ms are allowed" in fault


def test_a_read_back_that_shows_nothing_is_found(simulated_ni):
    def still(signals):
        read = signals.read_available
        return lambda: replace(block := read(), volts=np.zeros_like(block.volts))

    assert read_back_of(simulated_ni, read_available=still) == [
        "drive does not change when 0.2 V are written"
    ]


def test_ctrl_c_while_the_read_back_is_tried_leaves_no_voltage(simulated_ni, monkeypatch):
    output, signals, written = simulated_ni.output(), simulated_ni.signals(), []
    output.open()
    signals.open()
    write = output.write
    monkeypatch.setattr(output, "write", lambda volts: (written.append(volts), write(volts))[1])

    def wait(checks, seconds):
        if written:
            raise KeyboardInterrupt
        checks.clock.sleep_until(checks.clock.now() + seconds)

    monkeypatch.setattr("drivers.conformance.Checks.wait", wait)
    with pytest.raises(KeyboardInterrupt):
        read_back_faults(output, signals, 0.2, simulated_ni.clock)
    assert written == [0.2, 0.0]
    signals.close()
    output.close()


def test_the_ni_family_keeps_the_contract():
    family = BOARD_FAMILIES.get("ni")
    assert family_faults(family, family.settings(), RealClock()) == []


def test_an_ni_line_keeps_the_contract(simulated_ni):
    line = NiInterlock(simulated_ni.connection, simulated_ni.clock, "PCI6703/port0/line0")
    assert interlock_faults(line, simulated_ni.clock) == []


@pytest.mark.slow
def test_the_rescue_of_ni_boards_keeps_the_contract(tcp_ni):
    output = tcp_ni.output()
    output.open()
    output.write(0.2)
    place = OutputPlace(
        address=tcp_ni.connection.address,
        output_channel=tcp_ni.drive,
        drive_channel="PCI6034E/ai2",
        limit_board_V=0.25,
    )

    def read_V() -> float:
        signals = tcp_ni.signals(task_name="apart from the rescue")
        signals.open()
        try:
            return float(signals.measure(0.02)[2].mean())
        finally:
            signals.close()

    assert rescue_faults(NiRescue(place, tcp_ni.clock), tcp_ni.clock, read_V) == []


class Unlimited(NiVoltageOutput):
    """Checks no limit of its own."""

    def write(self, board_V: float):
        return super().write(min(max(board_V, -0.25), 0.25))


def test_an_output_that_refuses_nothing_is_found(simulated_ni):
    clock = simulated_ni.clock
    output = Unlimited(simulated_ni.connection, clock, simulated_ni.drive, 0.25)
    found = output_faults(output, 0.25, clock)
    assert any("write(0.2525) was not refused with LimitError" in fault for fault in found)


def test_boards_with_a_meter_keep_the_contract_of_inputs(simulated_ni):
    clock = simulated_ni.clock
    signals = MeteredInput(simulated_ni.signals(), meter_on(clock, Load()), clock)
    signals.board._inputs = signals.board._inputs[1:]  # all but the force
    signals.board._physical = signals.board._physical[1:]
    signals.board._ranges = signals.board._ranges[1:]
    assert signal_faults(signals, clock) == []


def test_a_connection_that_is_not_open_raises_device_errors_only():
    with pytest.raises(DeviceError):
        NiConnection("127.0.0.1:9").devices()
