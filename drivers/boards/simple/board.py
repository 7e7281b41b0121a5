"""What a simple board must do, and the keys that each family of them has.

Output, inputs, read-back and rescue are made of that (`connection`, `rescue`). An interlock's line,
a watchdog, a camera's trigger and timed runs are not: a family that has them fulfils
`drivers.boards.contract` by itself.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field

from drivers.boards.contract import BoardInput
from drivers.interfaces import DeviceIdentity, FloatArray


def _terminal(default: str, description: str) -> str:
    name: str = field(default=default, metadata={"description": description})
    return name


def _range(default: float, description: str) -> float:
    facts = {"gt": 0, "le": 100.0, "unit": "V", "description": description}
    largest: float = field(default=default, metadata=facts)
    return largest


@dataclass(frozen=True, kw_only=True)
class SimpleSettings:
    """Keys of the family's table. A subclass adds its own: numbers, texts and flags."""

    address: str = field(metadata={"description": "where the board is"})
    drive: str = _terminal("ao0", "output that drives the amplifier")
    force: str = _terminal("ai0", "input of the load cell")
    current: str = _terminal("ai1", "input of the current shunt")
    drive_readback: str = _terminal("ai2", "input of the sheet voltage")
    sample_rate_hz: float = field(
        default=1000.0, metadata={"gt": 0, "unit": "1/s", "description": "of each channel"}
    )
    force_range_V: float = _range(0.05, "largest voltage of the load cell, either sign")
    current_range_V: float = _range(0.5, "largest voltage across the shunt, either sign")
    drive_range_V: float = _range(5.0, "largest voltage at the sheet, either sign")


class SimpleBoard(ABC):
    """One board that holds its last voltage. Made of its settings; touches nothing until `open`.

    Only one program at a time has it: `open` fails while another one does, and the end of a program
    frees it. So a program that hung and was ended writes no voltage any more. A board that any
    program may write to cannot be a simple one.

    What a method raises becomes the cause in the operator's sentence, whatever its type. `open` may
    take 10 s, the other methods 50 ms; one that gets no answer raises after 1 s at most. They are
    called one at a time, in turn from several threads; only `close` may come amid another.
    """

    @abstractmethod
    def open(self) -> None:
        """Take the board; its output keeps its voltage. Called again after `close`."""

    @abstractmethod
    def write(self, volts: float) -> None:
        """Put a voltage on the output; return when the board has confirmed it."""

    @abstractmethod
    def start(self, inputs: Sequence[BoardInput], rate_hz: float) -> None:
        """Begin to sample these inputs together by the board's own clock, without end."""

    @abstractmethod
    def read(self) -> FloatArray:
        """Return volts (inputs, samples): all that came since `start` or the last call; no wait.

        Raises where samples were lost (`drivers.interfaces.LostSamplesError`).
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop sampling."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the board, which keeps its voltage. May be called twice, and after a fault."""

    def identity(self) -> DeviceIdentity | None:
        """Return what the board is; open. None: it cannot be asked."""
        return None

    def range_for(self, volts: float) -> float:
        """Return the input range, either sign, that it takes where so much is expected."""
        return volts

    def rate_for(self, rate_hz: float, channels: int) -> float:
        """Return the rate that it samples at where this one is asked for."""
        del channels
        return rate_hz
