"""From sheet volts to board volts: the amplifier, and the output that drives through it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from drivers.interfaces import DeviceError, LimitError, TimedVoltage, VoltageWrite

# A sheet voltage exactly at the limit must pass the board's limit after division by the gain:
# room for rounding, and a thousand times less than the board's resolution.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Amplifier:
    """Multiplies the board's voltage by `gain` (negative when it inverts)."""

    gain: float
    limit_sheet_V: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.gain) and self.gain != 0.0):
            raise LimitError(f"[amplifier] gain = {self.gain} must be a number other than 0")
        if not (math.isfinite(self.limit_sheet_V) and self.limit_sheet_V > 0.0):
            raise LimitError(
                f"[limits] sheet_voltage_V = {self.limit_sheet_V} must be a number above 0"
            )

    @property
    def limit_board_V(self) -> float:
        """Largest voltage, either sign, that the board may ever put out."""
        return self.limit_sheet_V / abs(self.gain) * (1.0 + ROUNDING)

    def board_V(self, sheet_V: float) -> float:
        """Board voltage for a sheet voltage; LimitError beyond the limit or for NaN."""
        if not abs(sheet_V) <= self.limit_sheet_V:  # so written, NaN is refused too
            raise LimitError(
                f"{sheet_V} V was asked for at the sheet, but the limit is "
                f"±{self.limit_sheet_V:g} V ([limits] sheet_voltage_V); nothing was written"
            )
        return sheet_V / self.gain


@dataclass(frozen=True)
class BoardWrite:
    """One write to a board: the clock just before it was sent and just after it was confirmed."""

    before_s: float
    after_s: float


class BoardOutput(Protocol):
    """An output in the board's own volts."""

    def open(self) -> None:
        """Take the output and write 0 V."""

    def write(self, board_V: float) -> BoardWrite:
        """Put `board_V` on the terminal; LimitError beyond the board's own limit."""

    def close(self) -> None:
        """Write 0 V and let go. May be called twice; raises when 0 V was refused."""

    def abandon(self) -> None:
        """Let go without a write: somebody else is going to write 0 V. Never raises."""


@runtime_checkable
class TimedBoardOutput(Protocol):
    """A `BoardOutput` that may put out a whole run by the clock of its board's inputs."""

    @property
    def is_timed(self) -> bool:
        """See `TimedOutput.is_timed`."""

    def load(self, waveform: Sequence[TimedVoltage], rate_hz: float) -> None:
        """See `TimedOutput.load`, in board volts."""

    def is_done(self) -> bool:
        """See `TimedOutput.is_done`."""

    def write(self, board_V: float) -> BoardWrite:
        """See `BoardOutput.write`; ends a run that was loaded."""


class SheetDrive:
    """The voltage at the sheet: a board's output through an amplifier.

    A `VoltageOutput`, and a `TimedOutput` where the board's output is a `TimedBoardOutput`.
    """

    def __init__(self, output: BoardOutput, amplifier: Amplifier) -> None:
        self._output = output
        self._amplifier = amplifier

    @property
    def limit_V(self) -> float:
        """See `VoltageOutput.limit_V`."""
        return self._amplifier.limit_sheet_V

    def open(self) -> None:
        """See `VoltageOutput.open`."""
        self._output.open()

    def write(self, sheet_V: float) -> VoltageWrite:
        """See `VoltageOutput.write`."""
        board_V = self._amplifier.board_V(sheet_V)
        done = self._output.write(board_V)
        return VoltageWrite(sheet_V, board_V, done.before_s, done.after_s)

    @property
    def is_timed(self) -> bool:
        """See `TimedOutput.is_timed`."""
        return isinstance(self._output, TimedBoardOutput) and self._output.is_timed

    def load(self, waveform: Sequence[TimedVoltage], rate_hz: float) -> Sequence[float]:
        """See `TimedOutput.load`."""
        output = self._timed()
        board_V = [self._amplifier.board_V(each.volts) for each in waveform]
        places = zip(waveform, board_V, strict=True)
        output.load([TimedVoltage(each.index, volts) for each, volts in places], rate_hz)
        return board_V

    def is_done(self) -> bool:
        """See `TimedOutput.is_done`."""
        return self._timed().is_done()

    def _timed(self) -> TimedBoardOutput:
        if isinstance(self._output, TimedBoardOutput):
            return self._output
        raise DeviceError("this output's board writes on demand only: it cannot be given a run")

    def close(self) -> None:
        """See `VoltageOutput.close`."""
        self._output.close()

    def abandon(self) -> None:
        """Let go of the output as it is: the guard is going to write 0 V at once."""
        self._output.abandon()
