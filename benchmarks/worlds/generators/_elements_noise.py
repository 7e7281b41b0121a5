"""Heavy-tailed noise: Student's t, correlated from one number to the next, and mains hum."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

from benchmarks.worlds.session.layout import Run

Array = npt.NDArray[np.float64]
DEGREES = 4.0
READING_N, SAMPLE_N = 0.03e-3, 0.07e-3  # standard deviations
LIKE_BEFORE = 0.4  # correlation of a number with the one before
HUM_N, HUM_HZ = 0.01e-3, 50.013  # amplitude; the mains are never quite at 50 Hz
POINT_M = 0.04e-3  # of a point of one image's curve
WAVE_M = 0.012e-3  # what all images of a condition have in common
SMOOTH = np.array([0.25, 0.5, 1.0, 0.5, 0.25])  # weights of neighbouring points in it


def heavy(random: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """Return numbers of Student's t with unit variance."""
    return random.standard_t(DEGREES, shape) * np.sqrt((DEGREES - 2.0) / DEGREES)


class RunNoise:
    """What one run's numbers are off by; nothing where `exact`."""

    def __init__(self, seed: int, run: Run, exact: bool) -> None:
        self.random = {
            key: np.random.default_rng((seed, 321, run.number, n))
            for n, key in enumerate(("reading", "series", "image", "mean"))
        }
        self.size = 0.0 if exact else 1.0
        self.phase = float(np.random.default_rng((seed, 320)).uniform(0.0, 2.0 * np.pi))
        self.run = run

    def readings(self, time_s: Array) -> Array:
        """Errors of force readings at these times of the run."""
        return self._force("reading", time_s, READING_N)

    def series(self, time_s: Array) -> Array:
        """Errors of the force over time."""
        return self._force("series", time_s, SAMPLE_N)

    def _force(self, key: str, time_s: Array, sigma: float) -> Array:
        new = heavy(self.random[key], (len(time_s) + 20,))
        new = new * np.sqrt(1.0 - LIKE_BEFORE**2)
        alike = lfilter([1.0], [1.0, -LIKE_BEFORE], new)[20:]
        turns = HUM_HZ * (self.run.start_s + time_s)
        hum = HUM_N * np.sin(2.0 * np.pi * turns + self.phase)
        return np.asarray(self.size * (sigma * alike + hum))

    def images(self, count: int, points: int) -> Array:
        """Errors of the curves of single images along the normal, (count, points)."""
        return self.size * heavy(self.random["image"], (count, points)) * POINT_M

    def wave(self, s_m: Array) -> Array:
        """What the images of one condition have in common, (points,)."""
        z = heavy(self.random["mean"], (len(s_m) + len(SMOOTH) - 1,))
        alike = np.convolve(z, SMOOTH / np.sqrt(np.sum(SMOOTH**2)), mode="valid")
        return np.asarray(self.size * WAVE_M * alike)
