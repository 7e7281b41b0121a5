"""Noise of the world `legendre`.

Force: a 16 bit board's steps, the amplifier's white noise, a bridge whose zero walks at random, and
the building, whose floor swings at two frequencies in bursts. Curves: each image lies a little
aside and turned against the one before, since it is registered on the clamp's few pixels; a point
errs with its neighbours, as an edge's blur does; all images of a condition share a slow wave.
Every stream has a key of its own.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from benchmarks.worlds.generators._legendre_ritz import Array
from benchmarks.worlds.session.layout import Run

STEP_N = 3.0e-6  # of the board: 0.2 N over 65536 steps
WHITE_N, SERIES_N = 45e-6, 60e-6
WALK_N, TICK_S = 2.5e-6, 0.05  # in a second, of the bridge's zero
FLOOR_N, FLOOR_HZ = (30e-6, 18e-6), (7.3, 12.9)
BURST_S = 3.0  # how long the floor keeps its swing
POINT_M, WAVE_M = 8.0e-6, 3.0e-6  # of a point in one image; of all images of a condition
NEXT_POINT, NEXT_IMAGE = 0.45, 0.5  # correlations
ASIDE, TURNED = 0.35, 0.45  # shares of a point's error, the second at the curve's end
WAVE_LENGTH_M = 11e-3
_WHITE, _SERIES, _WALK, _FLOOR, _IMAGE, _WAVE = range(0x1E70, 0x1E76)


class RunNoise:
    """What the numbers of one run are off by."""

    def __init__(self, seed: int, run: Run, exact: bool) -> None:
        self._seed, self._run, self._exact = seed, run.number, exact
        self._waves = self._random(_WAVE)

    def _random(self, key: int) -> np.random.Generator:
        return np.random.default_rng((self._seed, key, self._run))

    def readings(self, time_s: Array) -> Array:
        """Return errors of force readings."""
        white = WHITE_N * self._random(_WHITE).standard_normal(len(time_s))
        return self._if_any(white + self._slow(time_s))

    def series(self, time_s: Array) -> Array:
        """Return errors of the force over time."""
        white = SERIES_N * self._random(_SERIES).standard_normal(len(time_s))
        return self._if_any(white + self._slow(time_s))

    def _slow(self, time_s: Array) -> Array:
        """Return zero and floor, the same for readings and series."""
        ticks = 2 + int(np.max(time_s, initial=0.0) / TICK_S)
        at = TICK_S * np.arange(ticks)
        steps = self._random(_WALK).standard_normal(ticks)
        walk = np.cumsum(WALK_N * np.sqrt(TICK_S) * steps)
        shown = np.interp(time_s, at, walk)
        kept = float(np.exp(-TICK_S / BURST_S))
        for k, (size, hertz) in enumerate(zip(FLOOR_N, FLOOR_HZ, strict=True)):
            push = np.random.default_rng((self._seed, _FLOOR, self._run, k))
            both = push.standard_normal((ticks + 200, 2))  # it swung before the run
            slow = lfilter([np.sqrt(1.0 - kept**2)], [1.0, -kept], both, axis=0)[200:]
            c, s = (size * np.interp(time_s, at, slow[:, j]) for j in (0, 1))
            angle = 2.0 * np.pi * hertz * time_s
            shown = shown + c * np.cos(angle) + s * np.sin(angle)
        return np.asarray(shown)

    def images(self, count: int, points: int) -> Array:
        """Return errors along the normals, (count, points)."""
        r = self._random(_IMAGE)
        frame = lfilter(
            [np.sqrt(1.0 - NEXT_IMAGE**2)], [1.0, -NEXT_IMAGE], r.standard_normal((count + 20, 2)),
            axis=0,
        )[20:]  # fmt: skip
        fine = r.standard_normal((count, points + 20))
        blur = lfilter([np.sqrt(1.0 - NEXT_POINT**2)], [1.0, -NEXT_POINT], fine, axis=1)[:, 20:]
        along = np.linspace(0.0, 1.0, points)
        moved = ASIDE * frame[:, :1] + TURNED * frame[:, 1:] * along
        own = np.sqrt(1.0 - ASIDE**2 - TURNED**2 / 3.0)
        return self._if_any(POINT_M * (moved + own * blur))

    def wave(self, s_m: Array) -> Array:
        """Return what all images of the next condition have in common."""
        phase = self._waves.uniform(0.0, 2.0 * np.pi, 4)
        waves = WAVE_LENGTH_M * self._waves.uniform(0.8, 4.0, 4)
        one = np.cos(2.0 * np.pi * s_m[:, None] / waves + phase)
        return self._if_any(WAVE_M * np.sqrt(0.5) * np.sum(one, axis=1))

    def _if_any(self, errors: Array) -> Array:
        return np.zeros_like(errors) if self._exact else np.asarray(errors)


def quantised(force_N: Array) -> Array:
    """Return what the board shows."""
    return np.asarray(STEP_N * np.round(force_N / STEP_N))
