"""The device's own watchdog: it acts when labrig is silent.

It drops the interlock's line, and sets DAC0 or DAC1 where that drives the amplifier. It counts in
the device, so that it acts where program, guard, computer or network are gone. In strict mode only
its key clears it, so that no other program that talks to the device can. It writes no LJTick-DAC:
there the line must take the amplifier's supply away.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from contextlib import suppress

from drivers.boards.labjack.analog_output import OffsetStage
from drivers.boards.labjack.device import LabJackDevice
from drivers.boards.labjack.errors import OutputTakenError
from drivers.boards.labjack.registers import (
    OWNER,
    WATCHDOG_ADVANCED,
    WATCHDOG_CLEAR,
    WATCHDOG_DAC,
    WATCHDOG_DAC_V,
    WATCHDOG_DIO,
    WATCHDOG_DIO_DIRECTION,
    WATCHDOG_DIO_INHIBIT,
    WATCHDOG_DIO_STATE,
    WATCHDOG_ENABLE,
    WATCHDOG_KEY,
    WATCHDOG_RESET,
    WATCHDOG_STARTUP_S,
    WATCHDOG_STRICT,
    WATCHDOG_TIMEOUT_S,
    is_tick_dac,
    line_number,
    line_register,
)
from drivers.boards.labjack.wire import Write
from drivers.interfaces import Clock, DeviceError

TIMEOUT_S = 1  # the shortest that it has: it counts whole seconds
_EVERY_S = 0.05
_ALL_LINES = (1 << 23) - 1


class LabJackWatchdog:
    """The watchdog, and the line that is high while it is fed. An `Interlock`."""

    def __init__(
        self,
        device: LabJackDevice,
        clock: Clock,
        line: str | None,
        stage: OffsetStage,
        check_mark: Callable[[float], bool],
    ) -> None:
        """`check_mark`: told of the output's mark; whether that is still ours."""
        self._device = device
        self._clock = clock
        self._line = None if line is None else line_number(line)
        self._stage = stage
        self._check_mark = check_mark
        self._key = 0  # 0: not open
        self._due_s = 0.0

    def open(self) -> None:
        """Set the watchdog and start it, with the line low."""
        if self._key:
            return
        wire, doing = self._device.wire, "setting the watchdog"
        key = secrets.randbelow(2**16 - 1) + 1
        if self._line is not None:
            wire.write(doing, Write(line_register(self._line), 0))
        wire.write(doing, Write(WATCHDOG_ENABLE, 0))
        wanted = [*self._settings(), Write(WATCHDOG_KEY, key)]
        found = wire.read(doing, *(each.register for each in wanted))
        for each, now in zip(wanted, found, strict=True):
            if abs(now - each.value) > 1e-6:  # they are kept in flash, which wears
                wire.write(doing, each)
        wire.write(doing, Write(WATCHDOG_ENABLE, 1))
        if wire.read(doing, WATCHDOG_ENABLE)[0] != 1:
            raise DeviceError(
                f"{doing} failed: {wire.where} does not start it; update its firmware"
            )
        self._key, self._due_s = key, self._clock.now()

    def beat(self) -> None:
        """See `Interlock.beat`: feed the watchdog, and hold the line high."""
        if not self._key:
            raise DeviceError("the watchdog is not open")
        now_s = self._clock.now()
        if now_s < self._due_s:
            return
        self._due_s = now_s + 0.5 * _EVERY_S
        writes = [Write(WATCHDOG_CLEAR, self._key)]
        if self._line is not None:
            writes.append(Write(line_register(self._line), 1))
        (mark,) = self._device.wire.exchange("feeding the watchdog", writes, [OWNER])
        if not self._check_mark(mark):
            self._drop()
            raise OutputTakenError(
                "the output guard, `labrig safe` or another program has taken the output while it "
                "was watched; start the run again"
            )

    def close(self) -> None:
        """Drop the line and stop the watchdog. May be called twice."""
        if not self._key:
            return
        self._key = 0
        stop_watchdog(self._device, self._line)

    def _drop(self) -> None:
        if self._line is not None:
            with suppress(DeviceError):
                self._device.wire.write("dropping", Write(line_register(self._line), 0))

    def _settings(self) -> list[Write]:
        """Return what it does on time-out."""
        line = 0 if self._line is None else 1 << self._line
        dacs = [int(self._stage.terminal == name) for name in ("DAC0", "DAC1")]
        return [
            Write(WATCHDOG_TIMEOUT_S, TIMEOUT_S),
            Write(WATCHDOG_STARTUP_S, 0),
            Write(WATCHDOG_ADVANCED, 0),
            Write(WATCHDOG_STRICT, 1),
            Write(WATCHDOG_RESET, 0),
            Write(WATCHDOG_DIO, int(bool(line))),
            Write(WATCHDOG_DIO_STATE, 0),
            Write(WATCHDOG_DIO_DIRECTION, line),
            Write(WATCHDOG_DIO_INHIBIT, _ALL_LINES & ~line),
            *(Write(register, on) for register, on in zip(WATCHDOG_DAC, dacs, strict=True)),
            *(
                Write(register, self._stage.zero_V)
                for register, on in zip(WATCHDOG_DAC_V, dacs, strict=True)
                if on
            ),
        ]


def stop_watchdog(device: LabJackDevice, line: int | None) -> None:
    """Drop the line, then stop the watchdog. Raises DeviceError."""
    doing = "stopping the watchdog"
    if line is not None:
        device.wire.write(doing, Write(line_register(line), 0))
    device.wire.write(doing, Write(WATCHDOG_ENABLE, 0))


def what_it_does(stage: OffsetStage, line: str | None) -> str:
    """Return what happens when labrig is silent, in words; empty: nothing."""
    acts = [] if line is None else [f"drops {line}"]
    if not is_tick_dac(stage.terminal):
        acts.append(f"sets {stage.terminal} to {stage.zero_V:g} V")
    return f"the LabJack's watchdog {' and '.join(acts)} after {TIMEOUT_S} s" if acts else ""
