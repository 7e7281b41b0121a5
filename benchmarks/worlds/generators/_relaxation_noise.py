"""Noise of the world `relaxation`.

Force: white, a zero that wanders within seconds, the steps of a meter's display, and now and then a
stray reading. The steps are drawn as errors of their own: a displayed number that is rounded would
change by a whole step where next to nothing is hidden. Images: neighbouring points err together,
the pixels' grid beats with the sheet's edge, and frames shake.
"""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._relaxation_strip import Array
from benchmarks.worlds.session.layout import Run

WHITE_N, SAMPLE_N = 0.03e-3, 0.05e-3  # of a filtered reading; of a sample of a series
WANDER_N, WANDER_S = 0.012e-3, 2.5
STEP_N = 0.01e-3  # of the meter
STRAY_N, STRAYS = 0.12e-3, 1.0 / 160.0  # of readings
POINT_M, ALIKE = 9e-6, 0.4  # of a point in one image; correlation with the next of 25
SHAKE_M = 2e-6
BEAT_M, WAVE_M = 3e-6, 3.6e-6
_READING, _SERIES, _IMAGE, _WAVE = range(0x5E20, 0x5E24)


class RunNoise:
    """What the numbers of one run are off by."""

    def __init__(self, seed: int, run: Run, exact: bool) -> None:
        self._seed, self._run, self._exact = seed, run, exact
        self._waves = self._random(_WAVE)

    def _random(self, key: int) -> np.random.Generator:
        return np.random.default_rng((self._seed, key, self._run.number))

    def readings(self, time_s: Array) -> Array:
        """Return errors of readings."""
        r = self._random(_READING)
        stray = np.where(r.random(len(time_s)) < STRAYS, r.laplace(0.0, STRAY_N, len(time_s)), 0.0)
        white = WHITE_N * r.standard_normal(len(time_s))
        return self._shown(r, time_s, white + stray)

    def series(self, time_s: Array) -> Array:
        """Return errors of samples."""
        r = self._random(_SERIES)
        return self._shown(r, time_s, SAMPLE_N * r.standard_normal(len(time_s)))

    def _shown(self, r: np.random.Generator, time_s: Array, error: Array) -> Array:
        wander = WANDER_N * _markov(r, np.exp(-np.diff(time_s) / WANDER_S))
        step = STEP_N * (r.random(len(time_s)) - 0.5)
        return np.asarray((error + wander + step) * (not self._exact))

    def images(self, count: int, points: int) -> Array:
        """Return errors along the normals, (count, points)."""
        r = self._random(_IMAGE)
        alike = np.full(points - 1, ALIKE ** (24.0 / max(points - 1, 1)))
        rows = np.stack([_markov(r, alike) for _ in range(count)])
        shaken = POINT_M * rows + SHAKE_M * r.standard_normal((count, 1))
        return np.asarray(shaken * (not self._exact))

    def wave(self, s_m: Array) -> Array:
        """Return the next condition's beat of pixels and edge, the same in all its images."""
        r = self._waves
        pitch, phase = r.uniform(4e-3, 15e-3, 2), r.uniform(0.0, 2.0 * np.pi, 2)
        beat = BEAT_M * np.sin(2.0 * np.pi * s_m / pitch[:, None] + phase[:, None])
        rest = np.sqrt(WAVE_M**2 - BEAT_M**2) * r.standard_normal(len(s_m))
        return np.asarray((np.sum(beat, axis=0) + rest) * (not self._exact))


def _markov(r: np.random.Generator, alike: Array) -> Array:
    """Return numbers of unit variance, each correlated with the one before."""
    z = r.standard_normal(len(alike) + 1)
    for k, c in enumerate(alike.tolist()):
        z[k + 1] = c * z[k] + np.sqrt(1.0 - c**2) * z[k + 1]
    return np.asarray(z)
