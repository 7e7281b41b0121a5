"""Noise as a function of time: the same at the same time, however it is asked for."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

# splitmix64 (Steele, Lea, Flood 2014)
_ODD = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_DRIFT_WAVES = 12


def _mixed(bits: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    bits = (bits ^ (bits >> np.uint64(30))) * _MIX_1
    bits = (bits ^ (bits >> np.uint64(27))) * _MIX_2
    return bits ^ (bits >> np.uint64(31))


class WhiteNoise:
    """Independent standard normal values, one for each microsecond."""

    def __init__(self, seed: int, stream: int) -> None:
        state = np.random.SeedSequence((seed, stream)).generate_state(1, np.uint64)
        self._key = state[0]

    def at(self, since_s: FloatArray) -> FloatArray:
        """Values (n,) at times since the world's beginning."""
        ticks = np.rint(since_s * 1e6).astype(np.int64).astype(np.uint64)
        first = _mixed(self._key + ticks * _ODD)
        second = _mixed(first + _ODD)
        # 53 bits; never 0, for the logarithm
        u = ((first >> np.uint64(11)).astype(float) + 0.5) * 2.0**-53
        v = (second >> np.uint64(11)).astype(float) * 2.0**-53
        return np.asarray(np.sqrt(-2.0 * np.log(u)) * np.cos(2.0 * math.pi * v))


class SlowWander:
    """A sum of waves with equal amplitudes, random phases and periods spread evenly in logarithm.

    Its standard deviation is 1; it has about equal power in each octave.
    """

    def __init__(self, seed: int, stream: int, shortest_s: float, longest_s: float) -> None:
        random = np.random.default_rng((seed, stream))
        octaves = random.uniform(math.log(shortest_s), math.log(longest_s), _DRIFT_WAVES)
        self._omega = 2 * math.pi / np.exp(octaves)
        self._phase = random.uniform(0, 2 * math.pi, _DRIFT_WAVES)

    def at(self, since_s: FloatArray) -> FloatArray:
        """Values (n,) at times since the world's beginning."""
        result = np.zeros_like(since_s)
        for omega, phase in zip(self._omega, self._phase, strict=True):
            result += np.sin(omega * since_s + phase)
        return result * math.sqrt(2 / _DRIFT_WAVES)
