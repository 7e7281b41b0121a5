"""Stiffness and moment per volt, estimated again and again while a run goes on.

An extended Kalman filter (Simon, Optimal State Estimation, ch. 13) on the logarithms of both, which
wander slowly: a sheet that dries is seen while it dries. The measurements are means of the force
and points of the neutral curve. Each has an offset of its own in each run (the load cell's zero,
the camera's, errors of the initial curvature), so that only what follows the voltage counts.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.dynamics.beam import ContactSetup, DynamicBeam
from model.dynamics.online.grid_motion import GRID_S, POINTS, Drive, GridMotion, scaled
from model.measurements import FloatArray

SLOW = 2  # ln B, ln moment per volt, both over those of the model
DIFFERENCE = 0.01  # of a logarithm, for the sensitivities
STATIONS = (8, 12, 16, 20)  # points of the shape at which the curve is compared
WANDER_PER_ROOT_S = 3e-3  # of either logarithm: 2.3 % in a minute
OFFSET_N, OFFSET_M = 1e-3, 2e-3  # standard deviations that an offset begins with
DRIFT_N_PER_ROOT_S = 1e-5  # of the force's offset
FORCE_FLOOR_N, CURVE_FLOOR_M = 5e-6, 5e-5  # of one measurement: what the model leaves out
EARLY_S = 5e-3  # what moves is known to within its way in so long
FAR_M = 0.02  # a curve further off is another thing's
LINEAR = 0.03  # change of a logarithm after which the run is computed again about the new one
MOST_AGAIN = 4  # of these, in one run
MOST_KEPT = 2000  # measurements; a run with more is not computed again
MEAN_S = 0.1  # over which the force's means are
FORGET = 0.02  # of the mean square of the normalised innovations, for each measurement


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Logarithms of stiffness and moment per volt over the model's, with their covariance."""

    mean: FloatArray  # (2,)
    covariance: FloatArray  # (2, 2)

    @staticmethod
    def unknown(sigma: float = 0.3) -> Estimate:
        """Return what is known before the first run."""
        return Estimate(mean=np.zeros(SLOW), covariance=np.eye(SLOW) * sigma**2)

    def after(self, seconds: float) -> Estimate:
        """Return the same so much later."""
        grown = np.eye(SLOW) * WANDER_PER_ROOT_S**2 * max(seconds, 0.0)
        return Estimate(mean=self.mean, covariance=self.covariance + grown)

    @property
    def ratios(self) -> tuple[float, float]:
        """Return both parameters over the model's."""
        stiffness, moment = np.exp(self.mean)
        return float(stiffness), float(moment)

    @property
    def sigmas(self) -> tuple[float, float]:
        """Return their standard deviations, over the model's too."""
        by = np.exp(self.mean) * np.sqrt(np.diag(self.covariance))
        return float(by[0]), float(by[1])


@dataclass(frozen=True)
class _ForceOrCurve:
    """Means of the force (one) or points of a curve, at a time."""

    time_s: float
    force_N: float | None
    sigma_N: float
    curve_m: FloatArray | None  # (n, 2)


class RunEstimator:
    """Of one run. Measurements come in the order of their times."""

    def __init__(self, beam: DynamicBeam, rolls: ContactSetup | None, prior: Estimate) -> None:
        """Begin at rest at 0 V. Raises ModelError where that is not possible."""
        self._beam, self._rolls, self._prior = beam, rolls, prior
        self._kept: list[_ForceOrCurve] = []
        self._again = 0
        self._begin(prior.mean)

    @property
    def estimate(self) -> Estimate:
        """What is known now; wider where the measurements disagree more than they should."""
        worse = max(1.0, self._chi2)
        return Estimate(mean=self._x[:SLOW].copy(), covariance=worse * self._P[:SLOW, :SLOW].copy())

    def add_force(self, drive: Drive, time_s: float, force_N: float, sigma_N: float) -> None:
        """Take a mean of the force over MEAN_S about a time. Raises ModelError."""
        self._add(drive, _ForceOrCurve(time_s, force_N, sigma_N, None))

    def add_curve(self, drive: Drive, time_s: float, curve_m: FloatArray) -> None:
        """Take a neutral curve (n, 2), in m, from the clamp on. Raises ModelError."""
        self._add(drive, _ForceOrCurve(time_s, None, 0.0, curve_m))

    def _add(self, drive: Drive, measured: _ForceOrCurve) -> None:
        self._keep(measured)
        self._take(drive, measured)
        off = float(np.max(np.abs(self._x[:SLOW] - self._about)))
        if off > LINEAR and self._again < MOST_AGAIN and self._certain:
            self._again += 1
            self._begin(self._x[:SLOW].copy())
            for each in self._kept:
                self._take(drive, each)

    def _keep(self, measured: _ForceOrCurve) -> None:
        self._kept.append(measured)
        if len(self._kept) > MOST_KEPT:
            self._kept, self._again = [], MOST_AGAIN

    @property
    def _certain(self) -> bool:
        """Whether the estimate is worth a new beginning."""
        return bool(np.max(np.diag(self._P)[:SLOW]) < LINEAR**2)

    def _begin(self, about: FloatArray) -> None:
        self._about = about
        points = [about, *(about + DIFFERENCE * np.eye(SLOW))]
        self._motions = [
            GridMotion(scaled(self._beam, *np.exp(point)), self._rolls) for point in points
        ]
        offsets = [OFFSET_N] + [OFFSET_M] * len(STATIONS)
        self._x = np.concatenate([self._prior.mean, np.zeros(len(offsets))])
        self._P = np.zeros((len(self._x), len(self._x)))
        self._P[:SLOW, :SLOW] = self._prior.covariance
        self._P[range(SLOW, len(self._x)), range(SLOW, len(self._x))] = np.square(offsets)
        self._chi2, self._time_s = 1.0, 0.0

    def _take(self, drive: Drive, measured: _ForceOrCurve) -> None:
        self._wander(measured.time_s)
        for motion in self._motions:
            motion.advance(drive, measured.time_s + 0.5 * MEAN_S)
        if measured.force_N is not None and self._rolls is not None:
            self._take_force(measured)
        if measured.curve_m is not None:
            for station, found in self._curve_rows(measured.time_s, measured.curve_m):
                self._correct(SLOW + 1 + station, *found)

    def _wander(self, time_s: float) -> None:
        seconds = max(0.0, time_s - self._time_s)
        self._time_s = max(time_s, self._time_s)
        grown = [WANDER_PER_ROOT_S**2] * SLOW + [DRIFT_N_PER_ROOT_S**2] + [0.0] * len(STATIONS)
        self._P[np.diag_indices_from(self._P)] += seconds * np.array(grown)

    def _take_force(self, measured: _ForceOrCurve) -> None:
        assert measured.force_N is not None  # noqa: S101 - for the type checker
        first = max(0, round((measured.time_s - 0.5 * MEAN_S) / GRID_S))
        count = round(MEAN_S / GRID_S)
        pieces = [motion.force_N(first)[:count] for motion in self._motions]
        base, by_B, by_moment = (float(np.mean(piece)) for piece in pieces)
        rate = float(np.ptp(pieces[0])) / MEAN_S
        slope = np.array([by_B - base, by_moment - base]) / DIFFERENCE
        variance = measured.sigma_N**2 + FORCE_FLOOR_N**2 + (EARLY_S * rate) ** 2
        self._correct(SLOW, measured.force_N - base, slope, variance)

    def _curve_rows(
        self, time_s: float, curve_m: FloatArray
    ) -> Iterator[tuple[int, tuple[float, FloatArray, float]]]:
        """Yield of each station: its number, how far the curve is off, slopes and variance."""
        shapes = [motion.shape_at(time_s) for motion in self._motions]
        before = self._motions[0].shape_at(max(0.0, time_s - GRID_S))
        if any(shape is None for shape in [*shapes, before]):
            return
        base, by_B, by_moment = (np.asarray(shape) for shape in shapes)
        moved = np.hypot(*(base - np.asarray(before)).T)
        for number, k in enumerate(STATIONS):
            along = base[min(k + 1, POINTS - 1)] - base[k - 1]
            normal = np.array([-along[1], along[0]]) / np.hypot(*along)
            off_m = distance_along(curve_m, base[k], normal)
            if off_m is None or abs(off_m) > FAR_M:
                continue
            slope = np.array([(by_B - base)[k] @ normal, (by_moment - base)[k] @ normal])
            variance = CURVE_FLOOR_M**2 + (EARLY_S / GRID_S * moved[k]) ** 2
            yield number, (off_m, slope / DIFFERENCE, variance)

    def _correct(self, offset: int, off: float, slope: FloatArray, variance: float) -> None:
        """Update with one measurement: prediction + slope (x - about) + its offset + noise."""
        if not np.isfinite(off):
            return
        h = np.zeros(len(self._x))
        h[:SLOW], h[offset] = slope, 1.0
        expected = slope @ (self._x[:SLOW] - self._about) + self._x[offset]
        gain = self._P @ h
        spread = float(h @ gain) + variance
        innovation = off - float(expected)
        self._chi2 += FORGET * (min(innovation**2 / spread, 25.0) - self._chi2)
        self._x = self._x + gain * (innovation / spread)
        self._P = self._P - np.outer(gain, gain) / spread
        self._P = 0.5 * (self._P + self._P.T)


def distance_along(curve_m: FloatArray, place_m: FloatArray, normal: FloatArray) -> float | None:
    """Return how far a curve (n, 2) is from a place along a normal; None if they do not meet."""
    at = curve_m - place_m
    across, along = at @ normal, at @ np.array([normal[1], -normal[0]])
    turns = np.flatnonzero(np.sign(along[:-1]) != np.sign(along[1:]))
    if not len(turns):
        return None
    width = along[turns + 1] - along[turns]
    share = -along[turns] / np.where(width == 0.0, 1.0, width)
    met = across[turns] + share * (across[turns + 1] - across[turns])
    return float(met[np.argmin(np.abs(met))])
