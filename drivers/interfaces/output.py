"""The voltage on the sheet, and what drops it from outside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable


@dataclass(frozen=True)
class VoltageWrite:
    """One write of the drive voltage: what was sent, and between which two moments."""

    sheet_V: float
    board_V: float
    before_s: float  # clock time just before the request was sent
    after_s: float  # and just after the device confirmed it


@runtime_checkable
class VoltageOutput(Protocol):
    """The voltage at the sheet, through whatever amplifies it.

    The board holds its last value for ever: `close` writes 0 V first, and so must anything else
    that stops using the output.
    """

    @property
    def limit_V(self) -> float:
        """Largest sheet voltage, either sign, that `write` accepts."""

    def open(self) -> None:
        """Take the output and write 0 V. Raises DeviceNotFoundError, DeviceError."""

    def write(self, sheet_V: float) -> VoltageWrite:
        """Put `sheet_V` on the sheet; blocks for one round trip.

        Raises LimitError (nothing was sent) beyond the limit or for NaN, DeviceError otherwise.
        """

    def close(self) -> None:
        """Write 0 V and let go of the output. May be called twice; raises when 0 V was refused."""

    def abandon(self) -> None:
        """Let go without a write: somebody else is going to write 0 V. Never raises."""


@dataclass(frozen=True)
class TimedVoltage:
    """From sample `index` of an acquisition on, `volts` are at an output."""

    index: int
    volts: float


@runtime_checkable
class TimedOutput(Protocol):
    """A `VoltageOutput` that may put out a whole run by the clock of the signal input."""

    @property
    def is_timed(self) -> bool:
        """Whether its board can; known once it is open."""

    def load(self, waveform: Sequence[TimedVoltage], rate_hz: float) -> Sequence[float]:
        """Give the board the voltages of a run; return those at the board, in the same order.

        Sample 0 is that of the next start of the signal input, which starts the run. Before its
        first voltage the output is at 0 V, and so it is from the last one on, which must be 0 V:
        whatever becomes of this program, the board's buffer ends there and is not put out again.
        `write` ends the run at once. Raises LimitError (nothing was sent), DeviceError (at 0 V).
        """

    def is_done(self) -> bool:
        """Return whether the board has put out all of it; one round trip.

        Raises DeviceError when it has ended before its time: the output may be at any voltage of
        the run, and 0 V is still to be written.
        """


@runtime_checkable
class Interlock(Protocol):
    """A signal that the working loop keeps up, for an external interlock.

    See docs/explanation/safety.md.
    """

    def open(self) -> None:
        """Take the line; make no edge yet. Raises DeviceNotFoundError, DeviceError."""

    def beat(self) -> None:
        """Make an edge when one is due; called at least every 50 ms while energised.

        Blocks for one round trip at most. Raises DeviceError.
        """

    def close(self) -> None:
        """Let go of the line: without edges the interlock drops. May be called twice."""
