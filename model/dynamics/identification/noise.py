"""What the recordings hold beside the sheet: white noise, drift of the zero, hum of the mains.

A channel reads y = model + e + b + h: e is white, b a zero that begins anywhere within `zero` and
walks at random, h = a cos wt + b sin wt at the frequency of the mains. Amplitude and phase of the
hum may change slowly (the mains' frequency is not exactly 50 Hz). All are Gaussian; they are
integrated out, so that they cost what they hide.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from model.measurements import FloatArray, ModelError

HUM_KNOTS_S = 1.0  # between these amplitude and phase of the hum are a straight line


@dataclass(frozen=True, kw_only=True)
class ChannelNoise:
    """Standard deviations of one channel, in its unit."""

    white: float  # of a sample
    zero: float = 0.0  # of the zero at the begin of a run
    drift_per_sqrt_s: float = 0.0  # of the zero's change in a second
    hum: float = 0.0  # of the hum's cosine and sine

    def __post_init__(self) -> None:
        """Refuse what is no standard deviation."""
        if not 0.0 < self.white < np.inf:
            raise ModelError(f"the white noise of a channel must be positive, not {self.white:g}")
        for value in (self.zero, self.drift_per_sqrt_s, self.hum):
            if not 0.0 <= value < np.inf:
                raise ModelError(
                    f"zero, drift and hum of a channel must be zero or positive, not {value:g}"
                )


@dataclass(frozen=True, kw_only=True)
class RecordingNoise:
    """Noise of all that is recorded."""

    force: ChannelNoise  # N
    current: ChannelNoise  # A
    curve_m: float  # of a point of a curve, across it
    mains_hz: float = 50.0
    edge_s: float = 2e-4  # current samples nearer than this to a write are left out

    def __post_init__(self) -> None:
        """Refuse what no noise is."""
        if not 0.0 < self.curve_m < np.inf:
            raise ModelError(
                f"the standard deviation of the curves must be positive, not {self.curve_m:g} m"
            )
        if not 0.0 < self.mains_hz < np.inf or not 0.0 <= self.edge_s < np.inf:
            raise ModelError("the mains' frequency and the time left out at edges must be positive")


def tempered(noise: RecordingNoise, factor: float) -> RecordingNoise:
    """Return noise of force and curves so many times stronger: a search leans on the priors.

    The current says as much as before: the electrodes, sought before, stay where they are.
    """

    def stronger(of: ChannelNoise) -> ChannelNoise:
        return ChannelNoise(
            white=factor * of.white, zero=factor * of.zero, hum=factor * of.hum,
            drift_per_sqrt_s=factor * of.drift_per_sqrt_s,
        )  # fmt: skip

    return replace(noise, force=stronger(noise.force), curve_m=factor * noise.curve_m)


class Whitening:
    """Takes residuals of a channel to independent ones of variance 1: a linear map.

    White noise and walking zero by Kalman's innovations of the local level model (Durbin & Koopman,
    Time series analysis by state space methods, ch. 2); the hum's amplitudes by least squares with
    their prior. The sum of squares of the result is r' C^-1 r, C the covariance of the channel.
    """

    def __init__(self, noise: ChannelNoise, time_s: FloatArray, mains_hz: float) -> None:
        """Prepare the map for samples at `time_s` (n,)."""
        self._gain, self._scale = _innovations(noise, time_s)
        self._hum: FloatArray | None = None
        # of the map; half that of C^-1
        self.ln_determinant = float(np.sum(np.log(self._scale)))
        if noise.hum > 0.0:
            columns = noise.hum * self._level_free(_hum(time_s, mains_hz))
            with_prior = np.concatenate([columns, np.eye(columns.shape[1])])
            self._hum, triangle = np.linalg.qr(with_prior)
            self.ln_determinant -= float(np.sum(np.log(np.abs(np.diag(triangle)))))

    def __call__(self, columns: FloatArray) -> FloatArray:
        """Return whitened columns (n + h, m) of residuals (n, m); h: amplitudes of the hum."""
        white = self._level_free(columns)
        if self._hum is None:
            return white
        extra = len(self._hum) - len(white)
        padded = np.concatenate([white, np.zeros((extra, white.shape[1]))])
        return np.asarray(padded - self._hum @ (self._hum.T @ padded))

    def _level_free(self, columns: FloatArray) -> FloatArray:
        """Return (y_k - b_k)/sqrt(S_k), b_k the zero expected from what was read before."""
        if not self._gain.any():
            return np.asarray(columns * self._scale[:, None])
        from scipy.linalg import solve_banded  # slow to import

        n = len(columns)
        band = np.ones((2, n))
        band[1] = self._gain - 1.0  # b_k+1 - (1 - K_k) b_k = K_k y_k
        shifted = np.zeros_like(columns)
        shifted[1:] = self._gain[:-1, None] * columns[:-1]
        level = solve_banded((1, 0), band, shifted)
        return np.asarray((columns - level) * self._scale[:, None])


def _innovations(noise: ChannelNoise, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Kalman's gains K_k and 1/sqrt(S_k), (n,) each."""
    gain, scale = np.zeros(len(time_s)), np.empty(len(time_s))
    white, walk = noise.white**2, noise.drift_per_sqrt_s**2
    variance = noise.zero**2
    for k, step in enumerate(np.diff(time_s, append=time_s[-1:]).tolist()):
        total = variance + white
        gain[k] = variance / total
        scale[k] = total**-0.5
        variance = variance * white / total + walk * step
    return gain, scale


def _hum(time_s: FloatArray, mains_hz: float) -> FloatArray:
    """Return cosine and sine of the mains times hat functions, (n, 2 k)."""
    span = float(time_s[-1] - time_s[0])
    knots = np.linspace(time_s[0], time_s[-1], ceil(span / HUM_KNOTS_S) + 1)
    hats = np.stack([np.interp(time_s, knots, row) for row in np.eye(len(knots))], axis=1)
    turn = 2.0 * np.pi * mains_hz * time_s[:, None]
    return np.concatenate([np.cos(turn) * hats, np.sin(turn) * hats], axis=1)
