"""The inputs of a simple board as one acquisition."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np

from drivers.boards.acquisition import Acquisition
from drivers.boards.contract import BoardInput
from drivers.boards.simple.turns import BoardTurns
from drivers.interfaces import DeviceError, SampleClock, SignalBlock


class SimpleInputs(Acquisition):
    """A `SignalInput`."""

    def __init__(self, turns: BoardTurns, inputs: Sequence[BoardInput], asked_hz: float) -> None:
        super().__init__(turns.clock, inputs, asked_hz, turns.name)
        self._turns = turns
        self._is_open = False

    def open(self) -> None:
        """Learn ranges and rate."""
        if self._is_open:
            return
        with self._turns.turn(f"opening the inputs {self._wiring}") as board:
            ranges = [board.range_for(each.range_V) for each in self._inputs]
            rate_hz = board.rate_for(self._asked_hz, len(self._inputs))
        self._ranges = tuple(self._positive("range_for", "V", each) for each in ranges)
        self._rate_hz = self._positive("rate_for", "1/s", rate_hz)
        self._is_open = True

    def start(self) -> SampleClock:
        """See `SignalInput.start`."""
        self._require_open()
        self._require_stopped()
        with self._turns.turn(f"starting the inputs {self._wiring}") as board:
            before_s = self._clock.now()
            board.start(self._inputs, self._asked_hz)
            half_s = 0.5 * (self._clock.now() - before_s)
        self._running, self._next_index = True, 0
        return SampleClock(before_s + half_s, half_s, self._rate_hz)

    def read_available(self) -> SignalBlock:
        """See `SignalInput.read_available`."""
        self._require_open()
        self._require_running()
        doing = f"reading the inputs {self._wiring}"
        with self._turns.turn(doing) as board:
            volts = np.asarray(board.read())
            if volts.dtype.kind == "c":  # numpy would only warn, and drop a part
                raise TypeError(f"read returned complex numbers ({volts.dtype})")
            volts = volts.astype(float)
        if volts.ndim != 2 or len(volts) != len(self._inputs):
            raise DeviceError(
                f"{doing} failed: {self._turns.name} gave samples of the shape {volts.shape} for "
                f"{len(self._inputs)} inputs; its code must return (inputs, samples)"
            )
        return self._block(volts)

    def stop(self) -> None:
        """See `SignalInput.stop`."""
        if self._running:
            with self._turns.turn(f"stopping the inputs {self._wiring}") as board:
                board.stop()
            self._running = False  # not before: whoever failed to stop it may try again

    def close(self) -> None:
        """See `SignalInput.close`."""
        if self._is_open:
            self.stop()
            self._is_open = False

    def _positive(self, method: str, unit: str, value: object) -> float:
        """Return what a method of the board gave as a number: it is somebody else's code."""
        number = float(value) if isinstance(value, Real) else math.nan
        if not 0.0 < number < math.inf:
            raise DeviceError(
                f"opening the inputs {self._wiring} failed: {method} of {self._turns.name} "
                f"returned {value!r:.60}; its code must return a number above 0, in {unit}"
            )
        return number

    def _require_open(self) -> None:
        if not self._is_open:
            raise DeviceError(f"the inputs {self._wiring} are not open")
