import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.amplifier import Amplifier, BoardWrite, SheetDrive
from drivers.interfaces import LimitError, VoltageOutput


class Board:
    """A board output that remembers."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.volts: list[float] = []

    def open(self) -> None:
        self.calls.append("open")

    def write(self, board_V: float) -> BoardWrite:
        self.volts.append(board_V)
        return BoardWrite(1.0, 1.5)

    def close(self) -> None:
        self.calls.append("close")


def test_a_sheet_voltage_is_divided_by_the_gain():
    board = Board()
    drive = SheetDrive(board, Amplifier(gain=10.0, limit_sheet_V=2.5))
    done = drive.write(2.0)
    assert board.volts == [0.2]
    assert (done.sheet_V, done.board_V, done.before_s, done.after_s) == (2.0, 0.2, 1.0, 1.5)
    assert isinstance(drive, VoltageOutput)
    assert drive.limit_V == 2.5


def test_an_inverting_amplifier_is_driven_with_the_other_sign():
    assert Amplifier(gain=-10.0, limit_sheet_V=2.5).board_V(2.0) == -0.2


@pytest.mark.parametrize("asked", [2.5000001, -3.0, math.inf, -math.inf, math.nan])
def test_nothing_reaches_the_board_beyond_the_limit(asked):
    board = Board()
    with pytest.raises(LimitError, match="nothing was written"):
        SheetDrive(board, Amplifier(gain=10.0, limit_sheet_V=2.5)).write(asked)
    assert board.volts == []


@pytest.mark.slow
@given(gain=st.floats(0.1, 1000.0), limit=st.floats(0.01, 30.0), share=st.floats(-1.0, 1.0))
def test_every_allowed_sheet_voltage_is_within_the_boards_limit(gain, limit, share):
    amplifier = Amplifier(gain, limit)
    board_V = amplifier.board_V(share * limit)
    assert abs(board_V) <= amplifier.limit_board_V < 1.00001 * limit / gain


@pytest.mark.parametrize("gain", [0.0, math.nan, math.inf])
def test_an_amplifier_without_a_gain_is_refused(gain):
    with pytest.raises(LimitError, match="gain"):
        Amplifier(gain, 2.5)


@pytest.mark.parametrize("limit", [0.0, -1.0, math.nan, math.inf])
def test_a_drive_without_a_limit_is_refused(limit):
    with pytest.raises(LimitError, match="sheet_voltage_V"):
        Amplifier(10.0, limit)
