"""The inputs of a simple board as one acquisition."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from drivers.boards.contract import BoardInput
from drivers.boards.simple.turns import BoardTurns
from drivers.interfaces import (
    DeviceError,
    DeviceTimeoutError,
    FloatArray,
    SampleClock,
    SignalBlock,
)

_MARGIN_S = 2.0  # samples may come this much later than they are due


class SimpleInputs:
    """A `SignalInput`."""

    def __init__(self, turns: BoardTurns, inputs: Sequence[BoardInput], asked_hz: float) -> None:
        self._turns, self._inputs, self._asked_hz = turns, tuple(inputs), asked_hz
        self._ranges: tuple[float, ...] = tuple(each.range_V for each in inputs)
        self._rate_hz = asked_hz
        self._is_open = self._is_running = False
        self._next_index = 0

    @property
    def channels(self) -> Sequence[str]:
        """See `SignalInput.channels`."""
        return tuple(each.name for each in self._inputs)

    @property
    def ranges_V(self) -> Sequence[float]:
        """See `SignalInput.ranges_V`; before `open`, what was asked for."""
        return self._ranges

    @property
    def rate_hz(self) -> float:
        """See `SignalInput.rate_hz`."""
        return self._rate_hz

    def open(self) -> None:
        """Learn ranges and rate."""
        if self._is_open:
            return
        with self._turns.turn(f"opening the inputs {self._wiring}") as board:
            self._ranges = tuple(board.range_for(each.range_V) for each in self._inputs)
            self._rate_hz = board.rate_for(self._asked_hz, len(self._inputs))
        self._is_open = True

    def start(self) -> SampleClock:
        """See `SignalInput.start`."""
        self._require_open()
        if self._is_running:
            raise DeviceError(f"the inputs {self._wiring} are acquiring already")
        with self._turns.turn(f"starting the inputs {self._wiring}") as board:
            before_s = self._turns.clock.now()
            board.start(self._inputs, self._asked_hz)
            half_s = 0.5 * (self._turns.clock.now() - before_s)
        self._is_running, self._next_index = True, 0
        return SampleClock(before_s + half_s, half_s, self._rate_hz)

    def read_available(self) -> SignalBlock:
        """See `SignalInput.read_available`."""
        self._require_open()
        if not self._is_running:
            raise DeviceError(f"the inputs {self._wiring} are not acquiring: start them first")
        doing = f"reading the inputs {self._wiring}"
        with self._turns.turn(doing) as board:
            volts = np.asarray(board.read(), dtype=float)
        if volts.ndim != 2 or len(volts) != len(self._inputs):
            raise DeviceError(
                f"{doing} failed: {self._turns.name} gave samples of the shape {volts.shape} for "
                f"{len(self._inputs)} inputs; its code must return (inputs, samples)"
            )
        block = SignalBlock(self._next_index, volts, self._turns.clock.now())
        self._next_index += volts.shape[1]
        return block

    def stop(self) -> None:
        """See `SignalInput.stop`."""
        if self._is_running:
            with self._turns.turn(f"stopping the inputs {self._wiring}") as board:
                board.stop()
            self._is_running = False  # not before: whoever failed to stop it may try again

    def measure(self, duration_s: float) -> FloatArray:
        """See `SignalInput.measure`."""
        sample_clock = self.start()
        try:
            volts = self._wait_for(max(1, math.ceil(duration_s * self._rate_hz)), sample_clock)
        except BaseException:
            with suppress(DeviceError):  # the failure to read is the one to report
                self.stop()
            raise
        self.stop()
        return volts

    def close(self) -> None:
        """See `SignalInput.close`."""
        if self._is_open:
            self.stop()
            self._is_open = False

    @property
    def _wiring(self) -> str:
        return ", ".join(f"{each.terminal} ({each.name})" for each in self._inputs)

    def _require_open(self) -> None:
        if not self._is_open:
            raise DeviceError(f"the inputs {self._wiring} are not open")

    def _wait_for(self, wanted: int, sample_clock: SampleClock) -> FloatArray:
        """Return so many samples of each channel, once they have come."""
        clock, due_s = self._turns.clock, sample_clock.time_of(wanted)
        parts: list[FloatArray] = []
        have = 0
        while have < wanted:
            if clock.now() > due_s + _MARGIN_S:
                raise DeviceTimeoutError(
                    f"{self._wiring}: {wanted} samples were asked for, {have} came in time; check "
                    f"{self._turns.name}"
                )
            clock.sleep_until(max(due_s, clock.now() + 1e-3))
            parts.append(self.read_available().volts)
            have += parts[-1].shape[1]
        return np.concatenate(parts, axis=1)[:, :wanted]
