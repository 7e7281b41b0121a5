"""Make the output of a T-series device safe from another process than the one that drove it."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from drivers.boards.labjack.analog_output import OffsetStage
from drivers.boards.labjack.device import LabJackDevice
from drivers.boards.labjack.registers import (
    OWNER,
    STREAM_ENABLE,
    input_number,
    input_register,
    line_number,
)
from drivers.boards.labjack.watchdog import stop_watchdog
from drivers.boards.labjack.wire import Write
from drivers.interfaces import Clock
from drivers.safe_shutdown import SafetyReport, attempt, judge, mean_when_low

_READINGS = 5
_SETTLE_S = 0.02  # between two looks at a voltage that is not low yet
_END_S = 0.02  # what the other program had sent has arrived by then


@dataclass(frozen=True, kw_only=True)
class LabJackPlace:
    """Where the output and its read-back are, and what counts as 0 V."""

    address: str
    terminal: str  # TDAC0
    zero_V: float
    gain: float
    drive: str  # AIN4, the amplifier's output
    drive_range_V: float
    safe_below_V: float
    line: str | None  # the interlock's

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)


class LabJackRescue:
    """An `OutputRescue` with a connection of its own."""

    def __init__(self, place: LabJackPlace, clock: Clock) -> None:
        self._place = place
        self._clock = clock
        self._device = LabJackDevice(place.address, clock)
        self._stage = OffsetStage(place.terminal, place.zero_V, place.gain)

    def open(self) -> None:
        """See `OutputRescue.open`."""
        self._device.open()

    def make_safe(self, patience_s: float, on_held: Callable[[], None]) -> SafetyReport:
        """See `OutputRescue.make_safe`.

        Nobody can hold a register, so that nobody need be ended. The mark of the program that drove
        goes with the first write; that program sees it before, or with, its next one.
        """
        del patience_s, on_held
        failures: list[str] = []
        attempt(failures, self._zero)
        self._clock.sleep_until(self._clock.now() + _END_S)
        written = attempt(failures, self._zero)  # after what was under way then
        attempt(failures, self._free)
        seen: list[float] = []
        below_V = self._place.safe_below_V
        attempt(failures, lambda: seen.append(mean_when_low(self._drive_V, below_V)))
        return judge(written, seen[0] if seen else None, below_V, failures)

    def close(self) -> None:
        """See `OutputRescue.close`."""
        self._device.close()

    def _zero(self) -> None:
        zero = Write(self._stage.register, self._place.zero_V)
        self._device.wire.write("writing 0 V", zero, Write(OWNER, 0))

    def _free(self) -> None:
        """Stop stream and watchdog: the next program needs them."""
        line = self._place.line
        stop_watchdog(self._device, None if line is None else line_number(line))
        if self._device.wire.read("looking for a stream", STREAM_ENABLE)[0]:
            self._device.wire.write("stopping the stream", Write(STREAM_ENABLE, 0))

    def _drive_V(self) -> float:
        """Return the mean of a few readings of the amplifier's output."""
        number = input_number(self._place.drive)
        range_V = self._device.model.range_for(self._place.drive_range_V)
        doing = f"reading back {self._place.drive}"
        self._device.wire.write(doing, *self._device.input_settings(number, range_V))
        self._clock.sleep_until(self._clock.now() + _SETTLE_S)
        read = [self._device.wire.read(doing, input_register(number))[0] for _ in range(_READINGS)]
        return statistics.fmean(read)
