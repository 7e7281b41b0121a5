"""Noise of an old board: a zero with 1/f noise, steps of the converter, readings that stray.

The zero is a sum of two-state fluctuators whose dwell times are spread evenly over the logarithm.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

from benchmarks.worlds.session.layout import Run

Array = npt.NDArray[np.float64]
READING_N, SAMPLE_N = 0.022e-3, 0.06e-3  # white, of a reading and of one sample of a series
STEP_N = 0.012e-3  # of the converter
ZERO_N = 0.008e-3  # standard deviation of the zero
DWELL_S = np.geomspace(0.5, 300.0, 20)  # mean times between two changes of a fluctuator
WHOLE_S = 4000.0  # longer than any session
STRAYS, STRAY_N = 0.012, 0.1e-3  # share of readings that stray, and mean distance
POINT_M, ALIKE = 0.033e-3, 1.0 / 9.0  # of a point of one image; correlation length over the curve's
WAVE_M, WAVE_LENGTH_M = 0.011e-3, 7e-3  # what all images of a condition have in common


@lru_cache(maxsize=4)
def _changes(seed: int) -> tuple[tuple[float, Array], ...]:
    """Return the first state of each fluctuator, and when it changes."""
    found = []
    for n, dwell in enumerate(DWELL_S):
        random = np.random.default_rng((seed, 4710, n))
        first = float(random.choice([-1.0, 1.0]))
        count = int(1.3 * WHOLE_S / dwell) + 40
        found.append((first, np.cumsum(random.exponential(dwell, count))))
    return tuple(found)


def zero(seed: int, session_s: Array) -> Array:
    """Return the load cell's zero over the session."""
    states = [
        first * (1.0 - 2.0 * (np.searchsorted(changes, session_s) % 2))
        for first, changes in _changes(seed)
    ]
    return np.asarray(ZERO_N / np.sqrt(len(states)) * np.sum(states, axis=0))


class RunNoise:
    """What one run's numbers are off by; nothing where `exact`."""

    def __init__(self, seed: int, run: Run, exact: bool) -> None:
        self.random = {
            key: np.random.default_rng((seed, 4711, run.number, n))
            for n, key in enumerate(("reading", "series", "image", "mean"))
        }
        self.size = 0.0 if exact else 1.0
        self.seed, self.run = seed, run

    def readings(self, time_s: Array) -> Array:
        """Errors of force readings at these times of the run."""
        random, n = self.random["reading"], len(time_s)
        error = self._converted(random, time_s, READING_N)
        strays = (random.random(n) < STRAYS) * random.laplace(0.0, STRAY_N, n)
        return self.size * (error + strays)

    def series(self, time_s: Array) -> Array:
        """Errors of the force over time."""
        return self.size * self._converted(self.random["series"], time_s, SAMPLE_N)

    def _converted(self, random: np.random.Generator, time_s: Array, sigma: float) -> Array:
        """Return the rounded error of a force that lies anywhere between two steps."""
        within = random.uniform(-0.5, 0.5, len(time_s)) * STEP_N
        error = random.standard_normal(len(time_s)) * sigma
        error = error + zero(self.seed, self.run.start_s + time_s)
        return np.asarray(STEP_N * np.round((error + within) / STEP_N) - within)

    def images(self, count: int, points: int) -> Array:
        """Errors of the curves of single images along the normal, (count, points)."""
        kept = np.exp(-1.0 / (ALIKE * points))
        z = self.random["image"].standard_normal((count, points))
        z[:, 1:] *= np.sqrt(1.0 - kept**2)
        return np.asarray(self.size * POINT_M * lfilter([1.0], [1.0, -kept], z, axis=1))

    def wave(self, s_m: Array) -> Array:
        """What the images of one condition have in common, (points,)."""
        apart = np.abs(s_m[:, None] - s_m) / WAVE_LENGTH_M
        kernel = (1.0 + apart) * np.exp(-apart) + 1e-9 * np.eye(len(s_m))
        z = self.random["mean"].standard_normal(len(s_m))
        return np.asarray(self.size * WAVE_M * np.linalg.cholesky(kernel) @ z)
