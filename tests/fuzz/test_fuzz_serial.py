"""What a serial line may deliver: anything, at any length, without end."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import pytest

from drivers.force_sensors.dpm3 import Dpm3Meter
from drivers.interfaces import DeviceError, ThreadHandle
from drivers.positioners.zaber import RST_MICROSTEP_RAD, ZaberStage
from tests.fuzz.told import small_and_soon

CASES = 400
RADIUS_M = 0.04
STEPS_TO_10_MM = round(0.01 / RADIUS_M / RST_MICROSTEP_RAD)
Use = Callable[[Callable[[bytes], bytes]], None]
NUMBERS = ("0", "-1", "nan", "inf", "-inf", "1e400", "9" * 30, "9" * 5000, "", "x", "1 2", "0x10")
LIMIT_S = 900.0  # of virtual time for one call: the longest move that a stage may take


class Clock:
    """Sleeping is jumping."""

    def __init__(self) -> None:
        self.time_s = 0.0

    def now(self) -> float:
        return self.time_s

    def sleep_until(self, when: float) -> None:
        self.time_s = max(self.time_s, when)

    def start_thread(self, target: Callable[[], None], name: str) -> ThreadHandle:
        raise AssertionError("no serial driver needs a thread")


class Line:
    """A port at whose other end sits `answer(what was sent)`; an exchange takes a millisecond."""

    def __init__(self, clock: Clock, answer: Callable[[bytes], bytes]) -> None:
        self._clock, self._answer = clock, answer
        self._sent = b""
        self.exchanges = 0

    def write(self, data: bytes) -> None:
        self._sent = data

    def read_until(self, end: bytes) -> bytes:
        self._clock.time_s += 1e-3
        self.exchanges += 1
        assert self.exchanges < 200_000, "read for ever"
        return self._answer(self._sent)

    def reset_input_buffer(self) -> None:
        """Nothing is kept."""

    def close(self) -> None:
        """Nothing to do."""


def use_meter(answer: Callable[[bytes], bytes]) -> None:
    line = Line(Clock(), answer)
    meter = Dpm3Meter("COM1", serial_factory=lambda *_a, **_k: line)
    meter.open()
    assert abs(meter.read_force()) < 1e12


def use_stage(answer: Callable[[bytes], bytes]) -> None:
    clock = Clock()
    line = Line(clock, answer)
    stage = ZaberStage("COM1", clock, RADIUS_M, serial_factory=lambda *_a, **_k: line)
    for call in (stage.open, lambda: stage.move_to(0.01), stage.position, stage.home):
        began_s = clock.now()
        try:
            call()
        finally:
            assert clock.now() - began_s < LIMIT_S


def survives(use: Use, answer: Callable[[bytes], bytes]) -> bool:
    """Use a device; whether its answers were refused, which must be by a DeviceError."""
    with small_and_soon():
        try:
            use(answer)
        except DeviceError as fault:
            return 0 < len(str(fault)) < 2000
    return False


def stage_says(**settings: str) -> Callable[[bytes], bytes]:
    """A stage in good order, some of whose settings are odd."""
    sound = {
        "limit.min": "0",
        "limit.max": "1000000",
        "maxspeed": "150000",
        "pos": str(STEPS_TO_10_MM),
    }

    def answer(sent: bytes) -> bytes:
        words = sent.decode().split()[2:]
        data = (sound | settings).get(words[1], "0") if words[:1] == ["get"] else "0"
        return f"@01 1 OK {settings.get('state', 'IDLE')} -- {data}\r\n".encode()

    return answer


def test_a_sound_stage_is_used() -> None:
    assert not survives(use_stage, stage_says())


@pytest.mark.parametrize("use", [use_meter, use_stage])
def test_random_bytes_are_refused(use: Use) -> None:
    dice = random.Random(1)
    for _ in range(CASES):
        assert survives(use, lambda _: dice.randbytes(dice.randrange(40)) + b"\r\n")


@pytest.mark.parametrize("use", [use_meter, use_stage])
def test_replies_with_wrong_characters_are_refused_or_read(
    use: Use,
) -> None:
    dice = random.Random(2)
    sound = stage_says() if use is use_stage else lambda _: b"+001.25\r"

    def spoilt(sent: bytes) -> bytes:
        reply = bytearray(sound(sent))
        if dice.random() < 0.2:
            reply[dice.randrange(len(reply))] = dice.randrange(256)
        return bytes(reply)

    assert sum(survives(use, spoilt) for _ in range(CASES)) > CASES / 10


@pytest.mark.parametrize("use", [use_meter, use_stage])
@pytest.mark.parametrize(
    "flood",
    [
        b"!01 1 IDLE --\r\n",
        b"#01 1 info\r\n",
        b"!\n",
        b"",
        b"\n",
        b"\r",
        b"+1.0" * 10_000,
        b"@" * 9999,
    ],
    ids=lambda flood: repr(flood[:8]),
)
def test_the_same_line_for_ever_is_given_up(use: Use, flood: bytes) -> None:
    assert survives(use, lambda _: flood)


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("setting", ["limit.min", "limit.max", "maxspeed", "pos"])
def test_a_stage_with_settings_that_make_no_sense_is_refused_or_moved_in_bounded_time(
    setting: str, number: str
) -> None:
    for state in ("IDLE", "BUSY"):
        survives(use_stage, stage_says(**{setting: number, "state": state}))


def test_a_stage_that_is_busy_for_ever_is_stopped() -> None:
    assert survives(use_stage, stage_says(state="BUSY"))


@pytest.mark.parametrize("fault", [OSError("gone"), TypeError("pulled")])
@pytest.mark.parametrize("use", [use_meter, use_stage])
def test_a_port_that_raises_is_told_in_words(use: Use, fault: Exception) -> None:
    def answer(_: bytes) -> Any:
        raise fault

    assert survives(use, answer)
