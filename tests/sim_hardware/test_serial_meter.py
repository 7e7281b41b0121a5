"""The simulated panel meter, command by command."""

from __future__ import annotations

import re

import pytest

from sim_hardware.serial_devices import SimulatedDpm3Meter

GF = 9.80665e-3


class Clock:
    def __init__(self) -> None:
        self.now_s = 50.0

    def now(self) -> float:
        return self.now_s


class Ramp:
    """A force that grows by 1 gram-force a second from 2 at the clock's start."""

    def true_force_N(self, when: float) -> float:
        return (2 + (when - 50.0)) * GF


def meter(**settings) -> tuple[SimulatedDpm3Meter, Clock]:
    clock = Clock()
    return SimulatedDpm3Meter(Ramp(), clock, **{"noise_N": 0.0, **settings}), clock


def test_a_reading_is_sign_digits_and_point() -> None:
    device, clock = meter()
    assert device.respond(b"*1B1\r") == b"+02.000\r"
    clock.now_s = 40.5
    assert device.respond(b"*1B1\r") == b"-07.500\r"


def test_units_and_places_are_settings() -> None:
    device, _ = meter(newtons_per_unit=1e-3, decimals=2)
    assert device.respond(b"*1B1\r") == b"+019.61\r"


@pytest.mark.parametrize("command", [b"*0B1\r", b"*3B1\r", b"*3B1\n\r", b"\n*3B1\r"])
def test_its_own_address_and_zero_are_heard(command: bytes) -> None:
    device, _ = meter(address="3")
    assert device.respond(command) == b"+02.000\r"


@pytest.mark.parametrize("command", [b"*1B1\r", b"3B1\r", b"*3B1 \r", b"*3Z9\r", b"*3b1\r", b"\r"])
def test_anything_else_is_met_with_silence(command: bytes) -> None:
    device, _ = meter(address="3")
    assert device.respond(command) == b""


def test_a_command_may_come_in_pieces_or_with_others() -> None:
    device, _ = meter()
    assert device.respond(b"*1") == b""
    assert device.respond(b"B1\r*1B1\r*1B") == b"+02.000\r+02.000\r"
    assert device.respond(b"1\r") == b"+02.000\r"


def test_tare_makes_the_present_load_zero_and_can_be_undone() -> None:
    device, clock = meter()
    device.respond(b"*1CA\r")
    clock.now_s += 0.5
    assert device.respond(b"*1B1\r") == b"+00.500\r"
    device.respond(b"*1CB\r")
    assert device.respond(b"*1B1\r") == b"+02.500\r"


def test_continuous_mode_speaks_at_its_rate_and_hears_only_its_end() -> None:
    device, clock = meter(continuous=True, rate_hz=10)
    clock.now_s += 0.25
    assert device.poll() == b"+02.000\r+02.100\r+02.200\r"
    assert device.poll() == b""
    assert device.respond(b"*1B1\r*1CA\r") == b""
    device.respond(b"*1A1\r")
    clock.now_s += 1
    assert device.poll() == b""
    assert device.respond(b"*1B1\r") == b"+03.250\r"
    device.respond(b"*1A0\r")
    clock.now_s += 0.1
    assert device.poll() == b"+03.350\r"


def test_readings_that_nobody_fetched_for_long_are_lost() -> None:
    device, clock = meter(continuous=True, rate_hz=10)
    clock.now_s += 1000
    readings = device.poll().split(b"\r")[:-1]
    assert len(readings) == 10


@pytest.mark.parametrize(
    ("force_gf", "letter"), [(0.5, "A"), (-1.5, "B"), (3.0, "D"), (120.0, "H"), (-0.5, "A")]
)
def test_alarms_add_a_letter(force_gf: float, letter: str) -> None:
    device, clock = meter(alarms_N=(1 * GF, 2 * GF), line_feed=True)
    clock.now_s = 48.0 + force_gf
    reply = device.respond(b"*1B1\r")
    assert re.fullmatch(rb"[+-]\d\d\.\d\d\d%c\r\n" % letter.encode(), reply)
    if force_gf > 100:
        assert reply == b"+99.999H\r\n"


def test_second_alarm_alone() -> None:
    device, _ = meter(alarms_N=(5 * GF, 1 * GF))
    assert device.respond(b"*1B1\r") == b"+02.000C\r"


def test_noise_is_the_same_for_the_same_seed() -> None:
    one, two, other = (meter(noise_N=1e-3, seed=seed)[0] for seed in (1, 1, 2))
    replies = [device.respond(b"*1B1\r" * 5) for device in (one, two, other)]
    assert replies[0] == replies[1] != replies[2]
    assert len(set(replies[0].split(b"\r"))) == 6
