"""The output of a simple board: its own limit, and 0 V when it is opened and closed."""

from __future__ import annotations

from drivers.amplifier import BoardWrite
from drivers.boards.simple.turns import BoardTurns
from drivers.interfaces import DeviceError, LimitError


class SimpleOutput:
    """A `BoardOutput`."""

    def __init__(self, turns: BoardTurns, terminal: str, limit_V: float) -> None:
        self._turns, self._terminal, self._limit_V = turns, terminal, limit_V
        self._is_open = False

    def open(self) -> None:
        """Write 0 V; an output that is open already is left as it is."""
        if not self._is_open:
            self._write(0.0)
            self._is_open = True

    def write(self, board_V: float) -> BoardWrite:
        """See `BoardOutput.write`."""
        if not abs(board_V) <= self._limit_V:  # so written, NaN is refused too
            raise LimitError(
                f"{board_V} V was asked for at {self._terminal}, but this output is limited to "
                f"±{self._limit_V:.6g} V; nothing was written"
            )
        if not self._is_open:
            raise DeviceError(f"the output {self._terminal} is not open; nothing was written")
        return self._write(board_V)

    def close(self) -> None:
        """Write 0 V and let go of the output; where 0 V is refused it stays ours."""
        if self._is_open:
            self._write(0.0)
            self._is_open = False

    def abandon(self) -> None:
        """See `BoardOutput.abandon`."""
        self._is_open = False

    def _write(self, volts: float) -> BoardWrite:
        with self._turns.turn(f"writing {volts:g} V to {self._terminal}") as board:
            before_s = self._turns.clock.now()
            board.write(volts)
            return BoardWrite(before_s, self._turns.clock.now())
