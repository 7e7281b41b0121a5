"""The ports that simulated serial devices hang on: in memory, and real pseudo-terminals."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from types import SimpleNamespace

import pytest
import serial

from drivers.interfaces import RealClock
from sim_hardware.serial_devices import (
    FOLDER,
    InMemorySerial,
    PtyPort,
    SerialFaults,
    SimulatedDpm3Meter,
    SimulatedSerial,
    SimulatedZaberStage,
    faults,
)
from sim_hardware.serial_devices.wire import WrongAnswerError

GF = 9.80665e-3
needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


class JumpingClock:
    """A clock on which waiting takes no time."""

    def __init__(self) -> None:
        self.now_s = 50.0

    def now(self) -> float:
        return self.now_s

    def sleep_until(self, when: float) -> None:
        self.now_s = max(self.now_s, when)

    def start_thread(self, target, name):
        raise AssertionError("a serial port starts no thread")


class World:
    settings = SimpleNamespace(arc=SimpleNamespace(radius_mm=40.0))

    def __init__(self) -> None:
        self.places: list[float | None] = []

    def true_force_N(self, when: float) -> float:
        return 2 * GF

    def place(self, position_m: float | None, approach: str = "up") -> None:
        self.places.append(position_m)


def meter_port(faults: SerialFaults | None = None, **device) -> tuple[InMemorySerial, JumpingClock]:
    clock = JumpingClock()
    meter = SimulatedDpm3Meter(World(), clock, noise_N=0, **device)
    return InMemorySerial(meter, clock, timeout=0.5, faults=faults), clock


def test_an_exchange_takes_the_time_of_its_bytes() -> None:
    port, clock = meter_port()
    assert port.write(b"*1B1\r") == 5
    assert port.in_waiting == 0
    assert port.read_until(b"\r") == b"+02.000\r"
    assert clock.now() - 50.0 == pytest.approx((5 + 8) * 10 / 9600)


def test_reads_end_at_the_time_out_with_what_has_come() -> None:
    port, clock = meter_port()
    assert port.read(3) == b""
    assert clock.now() == pytest.approx(50.5)
    port.write(b"*1B1\r")
    assert port.read(3) == b"+02"
    assert port.read(50) == b".000\r"
    port.write(b"*1B1\r")
    assert port.read_until(b"!", size=4) == b"+02."
    assert port.in_waiting == 4
    port.reset_input_buffer()
    assert port.in_waiting == 0


def test_without_time_out_a_read_waits_for_the_device() -> None:
    port, clock = meter_port(continuous=True, rate_hz=0.5)
    port.timeout = None
    assert port.read_until(b"\r") == b"+02.000\r"
    assert port.read_until(b"\r") == b"+02.000\r"
    assert clock.now() == pytest.approx(52.0 + 80 / 9600, abs=2e-3)


def test_the_wrong_baud_rate_is_not_understood() -> None:
    clock = JumpingClock()
    meter = SimulatedDpm3Meter(World(), clock, noise_N=0, continuous=True, baudrate=19200)
    port = InMemorySerial(meter, clock, baudrate=9600, timeout=0.01)
    unasked = port.read(8)
    assert unasked
    assert unasked != b"+02.000\r"
    port.write(b"*1A1\r")
    clock.now_s += 1
    assert port.in_waiting


def test_a_closed_or_unplugged_port_raises_what_pyserial_raises() -> None:
    port, _ = meter_port()
    port.close()
    port.close()
    assert not port.is_open
    with pytest.raises(serial.PortNotOpenError):
        port.read(1)
    port.open()
    port.faults.unplugged = True
    with pytest.raises(serial.SerialException, match="disconnected"):
        port.write(b"*1B1\r")


def test_replies_can_be_garbled_broken_off_and_lost() -> None:
    port, _ = meter_port(SerialFaults(garbage={1}, half_line={2}, silent={3}))
    replies = []
    for _ in range(5):
        port.write(b"*1B1\r")
        replies.append(port.read(8))
    assert replies[0] == replies[4] == b"+02.000\r"
    assert len(replies[1]) == 8
    assert replies[1] != replies[0]
    assert replies[2] == b"+02."
    assert replies[3] == b""


# ------------------------------------------------------------------------------- pseudo-terminals


@pytest.fixture
def meter_pty() -> Iterator[PtyPort]:
    before = threading.active_count()
    port = PtyPort(SimulatedDpm3Meter(World(), RealClock(), noise_N=0, rate_hz=100))
    yield port
    port.stop()
    port.stop()
    assert threading.active_count() == before


@needs_pty
def test_pyserial_speaks_to_the_meter(meter_pty: PtyPort) -> None:
    with serial.Serial(meter_pty.path, 9600, timeout=1) as port:
        port.write(b"*1B1\r")
        assert port.read_until(b"\r") == b"+02.000\r"
        port.write(b"*0A0\r")
        assert port.read(24) == b"+02.000\r" * 3
        port.write(b"*0A1\r")
    with serial.Serial(meter_pty.path, 9600, timeout=1) as again:
        again.reset_input_buffer()
        again.write(b"*1B1\r")
        assert again.read_until(b"\r").endswith(b"+02.000\r")


def ask_often(port: serial.Serial) -> None:
    for _ in range(10):
        port.write(b"*1B1\r")
        port.read_until(b"\r")


@pytest.mark.slow
@needs_pty
def test_pyserial_meets_the_faults_of_the_cable(meter_pty: PtyPort) -> None:
    meter_pty.faults.silent = {0}
    meter_pty.faults.half_line = {1}
    with serial.Serial(meter_pty.path, 9600, timeout=0.2) as port:
        for expected in (b"", b"+02.", b"+02.000\r"):
            port.write(b"*1B1\r")
            assert port.read_until(b"\r") == expected
        meter_pty.faults.unplugged = True
        with pytest.raises((serial.SerialException, OSError)):
            ask_often(port)


@pytest.mark.slow
@needs_pty
def test_a_device_that_speaks_to_nobody_neither_blocks_nor_ends() -> None:
    port = PtyPort(
        SimulatedDpm3Meter(World(), RealClock(), noise_N=0, continuous=True, rate_hz=20_000)
    )
    clock = RealClock()
    clock.sleep_until(clock.now() + 0.3)
    with serial.Serial(port.path, 9600, timeout=1) as client:
        client.write(b"*1A1\r")
        clock.sleep_until(clock.now() + 0.05)
        client.reset_input_buffer()
        client.write(b"*1B1\r")
        assert client.read_until(b"\r") == b"+02.000\r"
    port.stop()


@needs_pty
@pytest.mark.slow
def test_the_makers_library_drives_the_stage() -> None:
    ascii_protocol = pytest.importorskip("zaber_motion.ascii")
    from zaber_motion.exceptions import BadDataException, MovementFailedException

    world = World()
    stage = SimulatedZaberStage(world, RealClock(), power_up_angle_rad=0.03)
    port = PtyPort(stage)
    try:
        with ascii_protocol.Connection.open_serial_port(port.path) as connection:
            (device,) = connection.detect_devices(identify_devices=False)
            axis = device.get_axis(1)
            assert axis.warnings.get_flags() == {"WR"}
            with pytest.raises(BadDataException):
                axis.move_absolute(1000)
            axis.home()
            axis.move_absolute(5_000)
            assert axis.get_position() == 5_000
            axis.move_relative(-2_000)
            assert axis.get_position() == 3_000
            assert not axis.is_busy()
            axis.settings.set("maxspeed", 100_000)
            assert axis.settings.get("maxspeed") == 100_000
            stage.axis.obstacle_rad = 0.02
            with pytest.raises(MovementFailedException) as caught:
                axis.move_absolute(9_000)
            assert caught.value.details.warnings == ["FS"]
            axis.move_velocity(-1000)
            axis.stop()
            assert not axis.is_busy()
    finally:
        port.stop()
    step_m = 0.04 * 4.090615434361711e-06
    assert world.places[:3] == pytest.approx([0, 5_000 * step_m, 3_000 * step_m], abs=1e-9)


@pytest.mark.parametrize("name", sorted(FOLDER.parts()))
def test_every_serial_device_fulfils_the_contract(name: str) -> None:
    assert faults(FOLDER.get(name)) == []


def test_what_is_wrong_with_a_serial_device_is_said() -> None:
    class Mute:
        baudrate = 0

        def respond(self, data: bytes) -> str:
            return str(data)

    assert faults(3) == ["SERIAL_DEVICE is of the type int, not a SimulatedSerial"]
    assert faults(SimulatedSerial("a b", lambda *_: Mute())) == [  # type: ignore[arg-type]
        "role = 'a b' must be one word",
        "baudrate = 0 must be a whole number above 0",
        "respond must return bytes, not str",
        "poll must return bytes, not NoneType",
    ]


def answering(answer) -> SimpleNamespace:
    def respond(_data: bytes) -> object:
        return answer()

    return SimpleNamespace(baudrate=9600, respond=respond, poll=lambda: b"")


def test_an_answer_that_is_no_bytes_is_told_as_such():
    line = InMemorySerial(answering(lambda: "text"), JumpingClock(), timeout=1.0)
    with pytest.raises(WrongAnswerError, match="returned str from respond; it must return bytes"):
        line.write(b"?")


@needs_pty
def test_a_served_device_that_fails_says_so_in_one_sentence(capfd):
    port = PtyPort(answering(lambda: 1 / 0))
    with serial.Serial(port.path, timeout=0.2) as line:
        line.write(b"?")
        port._thread.join(5)
    said = capfd.readouterr().err
    assert f"{port.path} is gone: the simulated device SimpleNamespace raised ZeroDiv" in said
    assert "test_serial_ports.py, line" in said
    assert "Traceback" not in said
