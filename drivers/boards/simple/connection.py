"""A simple board as a `BoardConnection`."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.boards.contract import CURRENT, DRIVE, FORCE, BoardFinding, BoardInput
from drivers.boards.simple.board import SimpleBoard, SimpleSettings
from drivers.boards.simple.inputs import SimpleInputs
from drivers.boards.simple.output import SimpleOutput
from drivers.boards.simple.turns import BoardTurns
from drivers.identity import identities_of
from drivers.interfaces import Clock, DeviceError, DeviceIdentity, Interlock


class SimpleConnection:
    """A `BoardConnection`, which reports what the board is."""

    def __init__(
        self, kind: str, board: SimpleBoard, settings: SimpleSettings, clock: Clock
    ) -> None:
        self._kind, self._settings = kind, settings
        self._turns = BoardTurns(board, f"{kind} at {settings.address}", clock)

    def open(self) -> None:
        """See `BoardConnection.open`."""
        self._turns.open()

    def findings(self) -> Sequence[BoardFinding]:
        """See `BoardConnection.findings`."""
        words = [f"{each.maker} {each.product} {each.serial}" for each in identities_of(self)]
        found = " ".join(" ".join(words).split()) or "it answers"
        return [BoardFinding(self._kind, ok=True, found=found, wanted="any")]

    def identities(self) -> Sequence[DeviceIdentity]:
        """See `Identified.identities`."""
        with self._turns.turn("asking what it is") as board:
            found = board.identity()
        return [] if found is None else [found]

    def voltage_output(self, limit_V: float) -> SimpleOutput:
        """See `BoardConnection.voltage_output`."""
        return SimpleOutput(self._turns, self._settings.drive, limit_V)

    def signal_input(self, inputs: Sequence[BoardInput]) -> SimpleInputs:
        """See `BoardConnection.signal_input`."""
        return SimpleInputs(self._turns, inputs, self._settings.sample_rate_hz)

    def interlock(self, line: str | None) -> Interlock:
        """There is none."""
        raise DeviceError(
            f"[interlock] line = {line}: {self._kind} has no line for an interlock; remove the "
            "table, or connect the interlock to other boards"
        )

    def close(self) -> None:
        """See `BoardConnection.close`."""
        self._turns.close()


def inputs_of(settings: SimpleSettings) -> tuple[BoardInput, ...]:
    """Return the channels that every family has."""
    return (
        BoardInput(FORCE, settings.force, settings.force_range_V),
        BoardInput(CURRENT, settings.current, settings.current_range_V),
        BoardInput(DRIVE, settings.drive_readback, settings.drive_range_V),
    )
