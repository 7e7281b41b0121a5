"""Noise as a function of time: the same at the same time, however it is asked for."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_TICKS_PER_S = 1e6
_WAVES = 12


class WhiteNoise:
    """Independent standard normal values, one for each microsecond."""

    def __init__(self, seed: int, stream: int) -> None:
        from sim_hardware.world.signals import kernels

        self._white = kernels.white
        self._key = np.random.SeedSequence((seed, stream)).generate_state(1, np.uint64)[0]

    def at(self, since_s: FloatArray) -> FloatArray:
        """Values (n,) at times since the world's beginning."""
        return self._white(np.rint(since_s * _TICKS_PER_S).astype(np.int64), self._key)


class SlowWander:
    """A sum of waves with equal amplitudes, random phases and periods spread evenly in logarithm.

    Its standard deviation is 1; it has about equal power in each octave.
    """

    def __init__(self, seed: int, stream: int, shortest_s: float, longest_s: float) -> None:
        from sim_hardware.world.signals import kernels

        self._waves = kernels.waves
        random = np.random.default_rng((seed, stream))
        octaves = random.uniform(math.log(shortest_s), math.log(longest_s), _WAVES)
        self._omega = 2 * math.pi / np.exp(octaves)
        self._phase = random.uniform(0, 2 * math.pi, _WAVES)

    def at(self, since_s: FloatArray) -> FloatArray:
        """Values (n,) at times since the world's beginning."""
        return self._waves(since_s, self._omega, self._phase) * math.sqrt(2 / _WAVES)
