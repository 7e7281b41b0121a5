"""The meter's driver against the simulated meter, in memory and on a pseudo-terminal."""

import sys

import pytest

from drivers.force_sensors.dpm3 import GRAM_FORCE_N, Dpm3Meter
from drivers.interfaces import (
    DeviceError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    ForceSensor,
    OverloadError,
    RealClock,
)
from sim_hardware import serial_devices as simulated
from sim_hardware.clock import VirtualClock

RESOLUTION_N = 0.001 * GRAM_FORCE_N


class Load:
    """The world as the meter sees it: a force."""

    def __init__(self, force_N: float = 0.0123) -> None:
        self.force_N = force_N

    def true_force_N(self, when: float) -> float:
        return self.force_N


def meter_on(clock, load: Load, faults=None, driver=None, **device) -> Dpm3Meter:
    device.setdefault("noise_N", 0.0)
    simulated_meter = simulated.SimulatedDpm3Meter(load, clock, **device)

    def port(name: str, **settings):
        return simulated.InMemorySerial(
            simulated_meter, clock, port=name, faults=faults, **settings
        )

    return Dpm3Meter("COM1", serial_factory=port, **(driver or {}))


@pytest.mark.parametrize("force_N", [0.0123, -0.05, 0.0])
@pytest.mark.parametrize("line_feed", [False, True])
@pytest.mark.parametrize("continuous", [False, True])
def test_the_force_is_read_whatever_mode_the_meter_was_left_in(force_N, line_feed, continuous):
    meter = meter_on(VirtualClock(), Load(force_N), line_feed=line_feed, continuous=continuous)
    assert isinstance(meter, ForceSensor)
    meter.open()
    for _ in range(3):
        assert meter.read_force() == pytest.approx(force_N, abs=0.51 * RESOLUTION_N)
    meter.close()
    meter.close()


def test_a_tare_makes_the_present_load_the_zero():
    load = Load(0.02)
    meter = meter_on(VirtualClock(), load)
    meter.open()
    meter.tare()
    load.force_N = 0.03
    assert meter.read_force() == pytest.approx(0.01, abs=1.01 * RESOLUTION_N)
    meter.untare()
    assert meter.read_force() == pytest.approx(0.03, abs=0.51 * RESOLUTION_N)
    meter.close()


def test_an_alarm_letter_is_kept_and_an_overload_raised():
    load = Load(0.02)
    meter = meter_on(VirtualClock(), load, alarms_N=(0.01, 0.05))
    meter.open()
    meter.read_force()
    assert meter.alarm == "B"
    load.force_N = 2.0
    with pytest.raises(OverloadError, match="unload"):
        meter.read_force()
    meter.close()


@pytest.mark.parametrize("baudrate", [300, 19200])
def test_every_baud_rate_gets_the_time_it_needs(baudrate):
    meter = meter_on(VirtualClock(), Load(), driver={"baudrate": baudrate}, baudrate=baudrate)
    meter.open()
    assert meter.read_force() == pytest.approx(0.0123, abs=RESOLUTION_N)
    meter.close()


def test_a_silent_meter_is_given_up_in_bounded_time():
    clock = VirtualClock()
    faults = simulated.SerialFaults(silent=range(1000))
    with pytest.raises(DeviceTimeoutError, match="DPM-3 meter on COM1 did not answer"):
        meter_on(clock, Load(), faults).open()
    assert clock.now() < 2.0


def test_garbage_and_broken_lines_are_named_and_the_next_reading_is_good():
    faults = simulated.SerialFaults()
    meter = meter_on(VirtualClock(), Load(), faults)
    meter.open()
    faults.garbage = {1}
    faults.half_line = {2}
    for _ in range(2):
        with pytest.raises(DeviceError, match="was expected"):
            meter.read_force()
    assert meter.read_force() == pytest.approx(0.0123, abs=RESOLUTION_N)
    meter.close()


def test_a_wrong_baud_rate_is_not_a_force():
    with pytest.raises(DeviceError):
        meter_on(VirtualClock(), Load(), driver={"baudrate": 4800}).open()


@pytest.mark.parametrize("reply", [b"999.99\r", b"+99999\r", b"+1.0Z\r", b"+1.0 \r", b"+1.0e3\r",
                                   b"+-1.0\r", b"+.\r", b"++1.0\r", b"nan\r", b"\r"])  # fmt: skip
def test_what_is_not_a_reading_is_refused(reply):
    class Port:
        def __init__(self, port: str, **settings) -> None:
            pass

        def write(self, data: bytes) -> None:
            pass

        def read_until(self, end: bytes) -> bytes:
            return reply

        def reset_input_buffer(self) -> None:
            pass

        def close(self) -> None:
            pass

    with pytest.raises(DeviceError, match="where a reading such as"):
        Dpm3Meter("COM1", serial_factory=Port).open()


def test_a_pulled_cable_is_said_so():
    faults = simulated.SerialFaults()
    meter = meter_on(VirtualClock(), Load(), faults)
    meter.open()
    faults.unplugged = True
    with pytest.raises(DeviceError, match="is gone"):
        meter.read_force()
    meter.close()


def test_a_port_that_is_not_there_is_refused_with_those_that_are():
    with pytest.raises(DeviceNotFoundError, match="ports found"):
        Dpm3Meter("/dev/no-such-port").open()


def test_a_baud_rate_that_the_meter_lacks_is_refused():
    with pytest.raises(DeviceError, match="115200 is none of 300"):
        Dpm3Meter("COM1", baudrate=115200)


def test_a_meter_is_spoken_to_by_its_address():
    meter = meter_on(VirtualClock(), Load(), driver={"address": 12}, address="C")
    meter.open()
    assert meter.read_force() == pytest.approx(0.0123, abs=RESOLUTION_N)
    with pytest.raises(DeviceTimeoutError):
        meter_on(VirtualClock(), Load(), driver={"address": 3}, address="C").open()
    with pytest.raises(DeviceError, match="0 to 31"):
        Dpm3Meter("COM1", address=32)


def test_a_meter_that_is_not_open_says_so():
    with pytest.raises(DeviceError, match="not open"):
        Dpm3Meter("COM1").read_force()


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
def test_the_meter_is_read_over_a_real_port():
    port = simulated.PtyPort(
        simulated.SimulatedDpm3Meter(Load(), RealClock(), noise_N=0.0, continuous=True)
    )
    try:
        meter = Dpm3Meter(port.path)
        meter.open()
        assert meter.read_force() == pytest.approx(0.0123, abs=RESOLUTION_N)
        meter.close()
    finally:
        port.stop()
