"""From volts at a terminal to the codes of the board's converter."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim_hardware.ni.boards.contract import AnalogInputs

FloatArray = npt.NDArray[np.float64]


class Converter:
    """The amplifier and converter of one channel, with its own repeatable noise.

    The noise belongs to the channel's samples in their order: reading in other blocks gives the
    same samples. Without a seed there is none, so that codes once converted stay what they are.
    """

    def __init__(self, side: AnalogInputs, range_V: float, seed: tuple[int, ...] | None) -> None:
        self.range_V = range_V
        self._codes = 1 << side.resolution_bits
        self.step_V = 2 * range_V / self._codes
        self._noise_V = 0.0 if seed is None else side.noise_V[side.ranges_V.index(range_V)]
        self._random = np.random.default_rng(seed)

    def codes(self, volts: FloatArray) -> npt.NDArray[np.int16]:
        """Return samples as codes, saturated beyond the range; they come in the order of time."""
        noisy = volts + self._noise_V * self._random.standard_normal(volts.shape)
        exact = np.rint(noisy / self.step_V)
        half = self._codes // 2
        return np.minimum(np.maximum(exact, -half), half - 1).astype(np.int16)

    def volts(self, codes: npt.NDArray[np.int16]) -> FloatArray:
        """Return codes as volts, as the driver scales them."""
        return np.multiply(codes, self.step_V, dtype=np.float64)
