"""What the inputs of all families have in common: names, states, and a measurement in one call."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from drivers.boards.contract import BoardInput
from drivers.interfaces import (
    Clock,
    DeviceError,
    DeviceTimeoutError,
    FloatArray,
    SampleClock,
    SignalBlock,
)

_MARGIN_S = 2.0  # samples may come this much later than they are due


class Acquisition(ABC):
    """The common part of a `SignalInput`; a family opens, starts, reads, stops and closes.

    `start` and `stop` of a family set `_running`, and `start` begins with `_next_index` 0.
    """

    def __init__(
        self, clock: Clock, inputs: Sequence[BoardInput], asked_hz: float, to_check: str
    ) -> None:
        """`to_check`: where samples do not come, such as the network."""
        self._clock = clock
        self._inputs = tuple(inputs)
        self._asked_hz = self._rate_hz = asked_hz
        self._ranges: tuple[float, ...] = tuple(each.range_V for each in inputs)
        self._to_check = to_check
        self._running = False
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
        """See `SignalInput.rate_hz`; before `open`, what was asked for."""
        return self._rate_hz

    @abstractmethod
    def start(self) -> SampleClock:
        """See `SignalInput.start`."""

    @abstractmethod
    def read_available(self) -> SignalBlock:
        """See `SignalInput.read_available`."""

    @abstractmethod
    def stop(self) -> None:
        """See `SignalInput.stop`."""

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

    @property
    def _wiring(self) -> str:
        return ", ".join(f"{each.terminal} ({each.name})" for each in self._inputs)

    def _require_stopped(self) -> None:
        if self._running:
            raise DeviceError(f"the inputs {self._wiring} are acquiring already")

    def _require_running(self) -> None:
        if not self._running:
            raise DeviceError(f"the inputs {self._wiring} are not acquiring: start them first")

    def _block(self, volts: FloatArray) -> SignalBlock:
        """Return samples that have just been read as the block that follows the one before."""
        block = SignalBlock(self._next_index, volts, self._clock.now())
        self._next_index += volts.shape[1]
        return block

    def _wait_for(self, wanted: int, sample_clock: SampleClock) -> FloatArray:
        """Return so many samples of each channel, once they have come."""
        due_s = sample_clock.time_of(wanted)
        parts: list[FloatArray] = []
        have = 0
        while have < wanted:
            if self._clock.now() > due_s + _MARGIN_S:
                raise DeviceTimeoutError(
                    f"{self._wiring}: {wanted} samples were asked for, {have} came in time; check "
                    f"{self._to_check}"
                )
            self._clock.sleep_until(max(due_s, self._clock.now() + 1e-3))
            parts.append(self.read_available().volts)
            have += parts[-1].shape[1]
        return np.concatenate(parts, axis=1)[:, :wanted]
