"""The two sides of a simulated rig, to which boards and camera are wired.

`world.World` is the simulated set-up; a loop-back wire and a replayed session are others. Times are
those of the injected clock, in s. Reads may ask for any time from the last read of that channel on;
writes come in the order of time.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


class AnalogSide(Protocol):
    """The analog side of a simulated rig: what board terminals see."""

    def write(self, device: str, channel: str, volts: float, when: float) -> None:
        """Change a board's output to `volts` at clock time `when` (channel such as `ao0`)."""

    def read(self, device: str, channel: str, times: FloatArray) -> FloatArray:
        """Volts at an input (channel such as `ai0`) at each clock time; before range and ADC."""


class OpticalSide(Protocol):
    """The optical side of a simulated rig: what a camera sees."""

    @property
    def frame_shape(self) -> tuple[int, int]:
        """Rows and columns."""

    @property
    def frame_rate_hz(self) -> float:
        """Frames per second."""

    def image(self, when: float, number: int) -> npt.NDArray[np.uint8]:
        """Return the frame with this number, its exposure ending at clock time `when`."""
