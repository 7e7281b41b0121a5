"""Gaussian noise: white, a load cell whose zero wanders slowly, images that are shifted."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.session.layout import Run

Array = npt.NDArray[np.float64]
READING_N, SAMPLE_N = 0.03e-3, 0.06e-3  # of a reading, of one sample of a series
DRIFT_N = 0.008e-3
PERIODS_S = (7.0, 300.0)
POINT_M = 0.04e-3  # of a point of one image's curve, along its normal
WAVE_M, WAVE_LENGTH_M = 0.012e-3, 8e-3  # what all images of a condition have in common


def wander(seed: int, time_s: Array) -> Array:
    """Return the load cell's zero over the session."""
    random = np.random.default_rng((seed, 20))
    periods = np.exp(random.uniform(*np.log(PERIODS_S), 16))
    a, b = random.standard_normal((2, 16)) * DRIFT_N / 4.0
    angle = 2.0 * np.pi * time_s[:, None] / periods
    return np.asarray(np.cos(angle) @ a + np.sin(angle) @ b)


class RunNoise:
    """What one run's numbers are off by; nothing where `exact`."""

    def __init__(self, seed: int, run: Run, exact: bool) -> None:
        self.random = {
            key: np.random.default_rng((seed, 21, run.number, n))
            for n, key in enumerate(("reading", "series", "image", "mean"))
        }
        self.size = 0.0 if exact else 1.0
        self.seed, self.run = seed, run

    def readings(self, time_s: Array) -> Array:
        """Errors of force readings at these times of the run."""
        return self._force("reading", time_s, READING_N)

    def series(self, time_s: Array) -> Array:
        """Errors of the force over time."""
        return self._force("series", time_s, SAMPLE_N)

    def _force(self, key: str, time_s: Array, sigma: float) -> Array:
        white = self.random[key].standard_normal(len(time_s)) * sigma
        return self.size * (white + wander(self.seed, self.run.start_s + time_s))

    def images(self, count: int, points: int) -> Array:
        """Errors of the curves of single images along the normal, (count, points)."""
        return self.size * self.random["image"].standard_normal((count, points)) * POINT_M

    def wave(self, s_m: Array) -> Array:
        """What the images of one condition have in common, (points,)."""
        z = self.random["mean"].standard_normal((2, 6))
        angle = 2.0 * np.pi * s_m[:, None] / WAVE_LENGTH_M * np.linspace(0.3, 1.3, 6)
        return np.asarray(
            self.size * WAVE_M / np.sqrt(6.0) * (np.cos(angle) @ z[0] + np.sin(angle) @ z[1])
        )
