"""The output that drives the amplifier: an LJTick-DAC, or DAC0 or DAC1 behind an offset stage.

Nothing in the device ties an output to the program that writes it. So labrig notes in a register
of its RAM who has taken the output. It reads that with every write, and before a write when it has
not for a while: a program that was stopped, and wakes after the guard has made the output safe,
writes no voltage any more.
"""

from __future__ import annotations

import secrets
from contextlib import suppress
from dataclasses import dataclass

from drivers.amplifier import BoardWrite
from drivers.boards.labjack.device import LabJackDevice
from drivers.boards.labjack.errors import OutputTakenError
from drivers.boards.labjack.registers import (
    OWNER,
    Model,
    Register,
    is_tick_dac,
    output_register,
)
from drivers.boards.labjack.wire import Write
from drivers.interfaces import Clock, DeviceError, LimitError

_TICK_DAC_V = 10.0
_ROUNDING_V = 1e-6
_KNOWN_S = 0.1  # a mark that was read so long ago may have been removed


@dataclass(frozen=True)
class OffsetStage:
    """Between a terminal and the amplifier: it puts out gain * (terminal - zero_V)."""

    terminal: str  # TDAC0, DAC0
    zero_V: float  # at the terminal, where the stage puts out 0 V
    gain: float

    @property
    def register(self) -> Register:
        """Return where the terminal's voltage is written."""
        return output_register(self.terminal)

    def terminal_V(self, board_V: float) -> float:
        """Return what to write for a voltage at the amplifier's input."""
        return self.zero_V + board_V / self.gain

    def reaches(self, limit_V: float, model: Model) -> bool:
        """Whether the terminal can give what both ends of the limit need."""
        low, high = (
            (-_TICK_DAC_V, _TICK_DAC_V) if is_tick_dac(self.terminal) else (0.0, model.dac_V)
        )
        ends = (self.terminal_V(-limit_V), self.terminal_V(limit_V))
        return min(ends) >= low - _ROUNDING_V and max(ends) <= high + _ROUNDING_V


class LabJackOutput:
    """An output in volts at the amplifier's input. A `BoardOutput`."""

    def __init__(
        self, device: LabJackDevice, clock: Clock, stage: OffsetStage, limit_V: float
    ) -> None:
        self._device = device
        self._clock = clock
        self._stage = stage
        self._limit_V = limit_V
        self._mark = 0  # ours while the output is ours; 0: it is not open
        self._marked_s = 0.0  # when it was read last
        self._last_V: float | None = None

    def open(self) -> None:
        """Take the output and write 0 V; an output that is open already is left as it is."""
        if self._mark:
            return
        wire, doing = self._device.wire, f"opening the output {self._stage.terminal}"
        if not self._stage.reaches(self._limit_V, self._device.model):
            raise DeviceError(
                f"{doing} failed: {self._stage.terminal} cannot give what ±{self._limit_V:g} V at "
                "the amplifier's input need; lower [limits] sheet_voltage_V, or change [labjack] "
                "zero_V and stage_gain with the stage"
            )
        if wire.read(doing, OWNER)[0]:
            raise OutputTakenError(
                f"{doing} failed: another labrig drives {wire.where}, or one died; when none runs, "
                "`labrig safe` writes 0 V and frees it"
            )
        self._mark = secrets.randbelow(2**32 - 1) + 1
        try:
            wire.write(doing, Write(OWNER, self._mark))
            self.check_mark(self._mark)
            self.write(0.0)
        except BaseException:
            self._mark = 0
            with suppress(DeviceError):
                wire.write(doing, Write(OWNER, 0))
            raise

    def write(self, board_V: float) -> BoardWrite:
        """Put `board_V` on the amplifier's input; blocks for one round trip."""
        terminal = self._stage.terminal
        if not abs(board_V) <= self._limit_V:  # so written, NaN is refused too
            raise LimitError(
                f"{board_V} V was asked for at {terminal}, but this output is limited to "
                f"±{self._limit_V:.6g} V; nothing was written"
            )
        if not self._mark:
            raise DeviceError(f"the output {terminal} is not open; nothing was written")
        wire, doing = self._device.wire, self._doing(board_V)
        if self._clock.now() > self._marked_s + _KNOWN_S and not self.check_mark(
            wire.read(doing, OWNER)[0]
        ):
            self._give_up()
        writes = [Write(self._stage.register, self._stage.terminal_V(board_V))]
        before_s = self._clock.now()
        (mark,) = wire.exchange(doing, writes, [OWNER])
        after_s = self._clock.now()
        if not self.check_mark(mark):
            self._give_up()
        self._last_V = board_V
        return BoardWrite(before_s, after_s)

    def close(self) -> None:
        """Write 0 V and let go of the output; where 0 V is refused it stays ours."""
        if not self._mark:
            return
        self.write(0.0)
        doing = f"closing the output {self._stage.terminal} (at 0 V)"
        self._device.wire.write(doing, Write(OWNER, 0))
        self._mark = 0

    def abandon(self) -> None:
        """Let go of the output as it is: for whoever else is going to write 0 V at once."""
        self._mark = 0

    def check_mark(self, mark: float) -> bool:
        """Note what was read from the register; return whether the output is still ours."""
        self._marked_s = self._clock.now()
        return self._mark != 0 and int(mark) == self._mark

    def _give_up(self) -> None:
        """Write 0 V after all: somebody else has made the output safe, or has taken it."""
        self._mark = 0
        doing = f"writing 0 V to {self._stage.terminal}"
        self._device.wire.write(doing, Write(self._stage.register, self._stage.zero_V))
        raise OutputTakenError(
            f"{doing} was needed: the output guard, `labrig safe` or another program has taken "
            "the output, or the device was restarted; start the run again"
        )

    def _doing(self, board_V: float) -> str:
        known = "none was confirmed yet"
        if self._last_V is not None:
            known = f"the last one confirmed is {self._last_V:g} V, before the amplifier"
        return f"writing {board_V:g} V to {self._stage.terminal} (which holds its voltage; {known})"
