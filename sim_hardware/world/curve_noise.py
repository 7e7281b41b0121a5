"""Errors of measured curves: a part that all images of a condition share, and each one's own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_IMAGES = 10  # in a mean image


@dataclass(frozen=True)
class CurveErrors:
    """Errors of a curve of a mean image along its normal, and the distance of its points."""

    white_m: float = 2e-6
    smooth_m: float = 2e-6
    smooth_length_m: float = 6e-3  # over which the smooth part is correlated
    spacing_m: float = 0.5e-3

    @property
    def sigma_m(self) -> float:
        """Standard deviation of one point."""
        return math.hypot(self.white_m, self.smooth_m)

    def places(self, length_m: float) -> FloatArray:
        """Return where the points are along a curve so long."""
        return np.linspace(0.0, length_m, 1 + round(length_m / self.spacing_m))

    def smooth_factor(self, s_m: FloatArray) -> FloatArray:
        """Matrix that makes the smooth errors of independent standard normal numbers."""
        apart = (s_m[:, None] - s_m) / self.smooth_length_m
        kernel = np.exp(-(apart**2))
        scale = self.smooth_m / np.sqrt(np.sum(kernel**2, axis=1, keepdims=True))
        return np.asarray(scale * kernel)


class CurveNoise:
    """The errors of the curves of one run: the same for the same seed."""

    def __init__(self, errors: CurveErrors, seed: Sequence[int]) -> None:
        self._errors = errors
        self._random = np.random.default_rng(seed)
        self._factor = np.empty((0, 0))
        self.white_m = errors.white_m * math.sqrt(_IMAGES)

    @property
    def reading_sigma_m(self) -> float:
        """Standard deviation of a point in one image."""
        return math.hypot(self.white_m, self._errors.smooth_m)

    def places(self, length_m: float) -> FloatArray:
        """Return where the points are along a curve so long."""
        s_m = self._errors.places(length_m)
        self._factor = self._errors.smooth_factor(s_m)
        return s_m

    def added(self, curves: Sequence[FloatArray], s_m: FloatArray) -> list[FloatArray]:
        """Return the curves (n, 2) of one condition with their errors along the normal."""
        smooth = self._factor @ self._random.standard_normal(s_m.size)
        result = []
        for curve in curves:
            off = smooth + self.white_m * self._random.standard_normal(s_m.size)
            along = np.gradient(curve, s_m, axis=0)
            along /= np.hypot(along[:, :1], along[:, 1:])
            result.append(curve + off[:, None] * along[:, ::-1] * (-1.0, 1.0))
        return result
