"""Functions of time and drive, value by value, compiled. Import this where it is used.

numpy may treat a value differently by where in an array it stands, in the last bit. Here it does
not, so that a signal does not depend on how it is cut into pieces.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim_hardware.jit import brief_jit

Floats = npt.NDArray[np.float64]

# splitmix64 (Steele, Lea, Flood 2014)
_ODD = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)


@brief_jit
def _mixed(bits: np.uint64) -> np.uint64:
    bits = (bits ^ (bits >> np.uint64(30))) * _MIX_1
    bits = (bits ^ (bits >> np.uint64(27))) * _MIX_2
    return bits ^ (bits >> np.uint64(31))


@brief_jit
def white(ticks: npt.NDArray[np.int64], key: np.uint64) -> Floats:
    """Return a standard normal value for each tick, independent of its neighbours."""
    result = np.empty(ticks.shape[0])
    for k in range(ticks.shape[0]):
        first = _mixed(key + np.uint64(ticks[k]) * _ODD)
        second = _mixed(first + _ODD)
        # 53 bits; never 0, for the logarithm
        u = (np.float64(first >> np.uint64(11)) + 0.5) * 2.0**-53
        v = np.float64(second >> np.uint64(11)) * 2.0**-53
        result[k] = math.sqrt(-2.0 * math.log(u)) * math.cos(2.0 * math.pi * v)
    return result


@brief_jit
def waves(times: Floats, omega: Floats, phase: Floats) -> Floats:
    """Sum of sines."""
    result = np.zeros(times.shape[0])
    for k in range(times.shape[0]):
        for j in range(omega.shape[0]):
            result[k] += math.sin(omega[j] * times[k] + phase[j])
    return result


@brief_jit
def settling(times: Floats, moves: Floats, lag: float) -> tuple[Floats, Floats]:
    """Value and integral, at times, of what goes to its level with a lag.

    `moves` (n, 4), one for each change of the level: its time, the level from then on, value and
    integral then. Times before the first go on from the first.
    """
    value, integral = np.empty_like(times), np.empty_like(times)
    last = moves.shape[0] - 1
    move = 0
    for k in range(times.shape[0]):
        if times[k] < moves[move, 0]:
            move = 0
        while move < last and moves[move + 1, 0] <= times[k]:
            move += 1
        since, level = times[k] - moves[move, 0], moves[move, 1]
        left = moves[move, 2] - level
        gone = math.exp(-since / lag)
        value[k] = level + left * gone
        integral[k] = moves[move, 3] + level * since + left * lag * (1.0 - gone)
    return value, integral


@brief_jit
def approach(times: Floats, most: float, rate: float) -> Floats:
    """From 0 at first like `rate * times`, and never beyond `most`."""
    result = np.empty_like(times)
    for k in range(times.shape[0]):
        result[k] = -most * math.expm1(-rate / most * times[k])
    return result


@brief_jit
def chebyshev(coefficients: Floats, x: Floats, into: Floats, at: npt.NDArray[np.int64]) -> None:
    """Series (rows, terms) at each x (n,), into the columns `at` (n,) of `into`."""
    rows, terms = coefficients.shape
    for k in range(x.shape[0]):
        for row in range(rows):
            above = higher = 0.0
            for term in range(terms - 1, 0, -1):
                higher, above = above, coefficients[row, term] + 2.0 * x[k] * above - higher
            into[row, at[k]] = coefficients[row, 0] + x[k] * above - higher
