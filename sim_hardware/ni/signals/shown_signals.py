"""What NI's own simulated devices show on inputs: sines, and lines that count."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim_hardware.ni.signals.adc import FloatArray

_FREQUENCY_HZ = 10.0
_LINES_OF_A_COUNT = 8  # lines 0 to 7 count, and so do 8 to 15
Words = npt.NDArray[np.uint32]


@dataclass(frozen=True)
class LimitSine:
    """A sine between the limits of a channel."""

    low_V: float
    high_V: float

    def volts(self, times_s: FloatArray) -> FloatArray:
        """Return the signal at some times."""
        middle, half = (self.high_V + self.low_V) / 2, (self.high_V - self.low_V) / 2
        return middle + half * np.sin(2 * np.pi * _FREQUENCY_HZ * times_s)


def count_of(line: str, samples: npt.NDArray[np.int64]) -> Words:
    """Return a line's level at the samples of a task: the lines of eight count in binary."""
    bit = int(line.rpartition("line")[2]) % _LINES_OF_A_COUNT
    return (samples >> bit & 1).astype(np.uint32)
