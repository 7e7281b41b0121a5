"""A family made of a few calls of its maker's library: it keeps the contracts, or says why not."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from drivers.boards.simple import SimpleBoard, SimpleSettings, simple_family
from drivers.boards.simple.conformance import simple_board_faults
from drivers.boards.simple.connection import inputs_of
from drivers.interfaces import DeviceError, LimitError, RealClock
from sim_hardware.clock import VirtualClock

SETTINGS = SimpleSettings(address="here")
INPUTS = inputs_of(SETTINGS)


class Box:
    """What all programs share: who has the board, and its voltages since when."""

    def __init__(self, clock: Any) -> None:
        self.clock, self.owner, self.edges = clock, None, [(-1.0, 0.0)]

    @property
    def volts(self) -> float:
        return self.edges[-1][1]


class Board(SimpleBoard):
    """A board in memory whose read-back is ten times its output."""

    box: Box

    def __init__(self, settings: SimpleSettings) -> None:
        self.settings = settings

    def open(self) -> None:
        if self.box.owner is not None:
            raise RuntimeError("in use")
        self.box.owner = self

    def write(self, volts: float) -> None:
        self.box.edges.append((self.box.clock.now(), volts))

    def start(self, inputs, rate_hz) -> None:
        self.count, self.rate_hz, self.sent = len(inputs), rate_hz, 0
        self.begun_s = self.box.clock.now()

    def read(self):
        first, now_s = self.sent, self.box.clock.now()
        self.sent = int((now_s - self.begun_s) * self.rate_hz)
        times_s = self.begun_s + np.arange(first, self.sent) / self.rate_hz
        since_s, volts = np.array(self.box.edges).T
        seen_V = 10.0 * volts[np.searchsorted(since_s, times_s, side="right") - 1]
        return np.tile(seen_V, (self.count, 1))

    def stop(self) -> None: ...

    def close(self) -> None:
        if self.box.owner is self:
            self.box.owner = None


def family(clock: Any, **overridden: Any):
    board = type("Mine", (Board,), {"box": Box(clock), **overridden})
    made = simple_family(kind="mine", help="ours", settings=SimpleSettings, board=board)
    return made, board.box


def opened(**overridden: Any):
    clock = VirtualClock()
    made, box = family(clock, **overridden)
    connection = made.connect(SETTINGS, clock, None)
    connection.open()
    return made, connection, box


def test_a_board_of_six_methods_keeps_every_contract():
    clock = VirtualClock()
    made, _ = family(clock)
    assert simple_board_faults(made, SETTINGS, 0.25, clock) == []


def nothing(*_: object) -> None: ...


def transposed(self):
    return Board.read(self).T


def late(self, volts):
    self.box.edges.append((self.box.clock.now() + 0.1, volts))


@pytest.mark.parametrize(
    ("overridden", "sentence"),
    [
        ({"open": nothing}, "open while another program has the board was not refused"),
        ({"write": nothing}, "drive does not change when 0.25 V are written"),
        ({"write": nothing}, "the output must be energised"),
        ({"write": late}, "ms after it, by the samples' clock; 50 ms are allowed"),
        ({"read": transposed}, "its code must return (inputs, samples)"),
    ],
)
def test_a_fault_of_a_board_is_found(overridden, sentence):
    clock = VirtualClock()
    made, _ = family(clock, **overridden)
    assert sentence in "; ".join(simple_board_faults(made, SETTINGS, 0.25, clock))


def test_what_a_library_raises_becomes_the_cause_in_one_sentence():
    def refused(self, volts):
        raise ValueError("code 17:\n no such channel.")

    _, connection, _ = opened(write=refused)
    with pytest.raises(DeviceError) as raised:
        connection.voltage_output(0.25).open()
    assert str(raised.value) == (
        "writing 0 V to ao0 failed: mine at here: code 17: no such channel"
    )


def test_no_value_beyond_the_limit_reaches_the_board():
    _, connection, box = opened()
    output = connection.voltage_output(0.25)
    output.open()
    for volts in (0.26, -0.26, float("nan"), float("inf")):
        with pytest.raises(LimitError):
            output.write(volts)
    assert {volts for _, volts in box.edges} == {0.0}


def test_a_rescue_ends_the_program_that_holds_the_board():
    made, connection, box = opened()
    output = connection.voltage_output(0.25)
    output.open()
    output.write(0.25)
    place = json.loads(json.dumps(made.output_place(SETTINGS, 0.25, 0.05, None)))
    rescue = made.rescue(place, box.clock)
    rescue.open()
    assert box.volts == 0.25  # it takes nothing before it must
    report = rescue.make_safe(3.0, connection.close)
    assert report.is_safe
    assert box.volts == 0.0


def test_a_board_that_nobody_lets_go_of_is_not_reported_safe():
    made, connection, box = opened()
    connection.voltage_output(0.25).open()
    rescue = made.rescue(made.output_place(SETTINGS, 0.25, 0.05, None), box.clock)
    report = rescue.make_safe(0.5, lambda: None)
    assert not report.is_safe
    assert "whether another program has it" in report.text


def test_a_place_that_makes_no_sense_is_one_sentence():
    made, _ = family(VirtualClock())
    with pytest.raises(DeviceError, match="the place of the output cannot be read"):
        made.rescue({"settings": {"unknown": 1}}, RealClock())


def test_a_board_without_a_line_refuses_an_interlock():
    _, connection, _ = opened()
    with pytest.raises(DeviceError, match="has no line for an interlock"):
        connection.interlock("port0/line0")


@pytest.mark.parametrize("wrong", [None, "1 kHz", float("nan"), 0.0, -1.0])
@pytest.mark.parametrize("method", ["range_for", "rate_for"])
def test_a_range_or_rate_that_is_no_number_above_0_is_named(method, wrong):
    _, connection, _ = opened(**{method: lambda self, *asked: wrong})
    signals = connection.signal_input(INPUTS)
    with pytest.raises(DeviceError, match=f"{method} of mine at here returned .*number above 0"):
        signals.open()


def test_complex_samples_are_refused():
    _, connection, _ = opened(read=lambda self: np.zeros((self.count, 5), dtype=complex))
    signals = connection.signal_input(INPUTS)
    signals.open()
    signals.start()
    with pytest.raises(DeviceError, match="complex"):
        signals.read_available()


@pytest.mark.parametrize("told", ["a box", None, 7])
def test_a_board_whose_identity_is_none_is_used_and_not_known(told):
    _, connection, _ = opened(identity=lambda self: told)
    assert connection.findings()[0].found == "it answers"


def test_a_board_whose_identity_fails_is_used_and_not_known():
    def fails(self):
        raise RuntimeError("no id")

    _, connection, _ = opened(identity=fails)
    assert connection.findings()[0].found == "it answers"


def test_boards_without_a_simulated_one_are_not_reached_from_a_simulated_rig():
    clock = VirtualClock()
    made, box = family(clock)
    with pytest.raises(DeviceError, match="the driver of these boards cannot be simulated"):
        made.connect(SETTINGS, clock, lambda: None)
    assert box.owner is None
