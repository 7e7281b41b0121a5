"""A rig without hardware, on which nothing has to be waited for; needs numpy only.

It is handed to labrig and to its peers, which live in environments of their own.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

RATE_HZ = 1000.0
PULSE_S, SAMPLE_AT_S, HALF_WINDOW_S = 0.6, 0.5, 0.1
VOLTAGES_V = (2.0, -2.0)


class NoWaitClock:
    """Time that is where it is wanted at once."""

    def __init__(self) -> None:
        self._now_s = 0.0

    def now(self) -> float:
        return self._now_s

    def sleep_until(self, when: float) -> None:
        self._now_s = max(self._now_s, when)


class NoWaitDevice:
    """An output, and a sampled input whose samples are there as soon as their time has come."""

    def __init__(self, clock: NoWaitClock) -> None:
        self._clock = clock
        self._noise_V = np.random.default_rng(0).normal(0.0, 1e-4, 2000)
        self._volts = self._before_V = 0.0
        self._since = 0  # index of the first sample at the present voltage
        reach = round(HALF_WINDOW_S * RATE_HZ)
        weights = np.cos(0.5 * np.pi * np.arange(-reach, reach + 1) / reach) ** 2
        self._weights = weights / weights.sum()

    def write(self, volts: float) -> None:
        self._before_V, self._volts = self._volts, volts
        self._since = math.ceil(self._clock.now() * RATE_HZ)

    def samples(self, first: int, count: int) -> npt.NDArray[np.float64]:
        """The input's samples from index `first` on."""
        index = np.arange(first, first + count)
        levels = np.where(index < self._since, self._before_V, self._volts)
        return levels + np.take(self._noise_V, index, mode="wrap")

    def filtered_force(self, at_s: float) -> float:
        """Mean of the samples within the window around a moment, with weights of Hann's."""
        centre = math.floor(at_s * RATE_HZ)
        reach = (len(self._weights) - 1) // 2
        return float(self.samples(centre - reach, len(self._weights)) @ self._weights)


def reading(clock: NoWaitClock, device: NoWaitDevice, volts: float) -> float:
    """The reading as a plain program makes it: write, wait, read the filtered force."""
    written_s = clock.now()
    device.write(volts)
    clock.sleep_until(written_s + PULSE_S)
    return device.filtered_force(written_s + SAMPLE_AT_S)
