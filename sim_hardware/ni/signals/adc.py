"""From volts at a terminal to the codes of a 16 bit converter."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim_hardware.ni.boards.boards import AnalogIn

FloatArray = npt.NDArray[np.float64]
_LOWEST, _HIGHEST = -(2**15), 2**15 - 1


class Converter:
    """One channel's way through the amplifier and the converter, with its own repeatable noise.

    The noise belongs to the channel's samples in their order: reading in other blocks gives the
    same samples. Without a seed there is none, so that codes once converted stay what they are.
    """

    def __init__(self, side: AnalogIn, range_V: float, seed: tuple[int, ...] | None) -> None:
        self.range_V = range_V
        self.step_V = 2 * range_V / 2**16
        self._noise_V = 0.0 if seed is None else side.noise_V[side.ranges_V.index(range_V)]
        self._random = np.random.default_rng(seed)

    def codes(self, volts: FloatArray) -> npt.NDArray[np.int16]:
        """The converter's codes; beyond the range it saturates. Takes samples in their order."""
        noisy = volts + self._noise_V * self._random.standard_normal(volts.shape)
        exact = np.rint(noisy / self.step_V)
        return np.minimum(np.maximum(exact, _LOWEST), _HIGHEST).astype(np.int16)

    def volts(self, codes: npt.NDArray[np.int16]) -> FloatArray:
        """What the driver makes of codes."""
        return np.multiply(codes, self.step_V, dtype=np.float64)
