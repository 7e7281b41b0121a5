"""Measured curves of all conditions in one array, and their modes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.polynomial import legendre

from model.measurements import Curve, FloatArray

PAST_THE_END = 1.001  # of the sheet: measured points farther out are left out


class StackedCurves:
    """Curves as arrays (K, S), shorter ones padded with their last place.

    `project` (K, M, S) turns distances at the points into the coefficients of M modes.
    """

    def __init__(self, curves: Sequence[Curve | None], end_m: float, modes: int) -> None:
        longest = max([2, *(len(c.s_m) for c in curves if c is not None)])
        self.given = np.array([c is not None for c in curves])
        shape = (len(curves), longest)
        self.s_m, self.x_m, self.y_m = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        self.project = np.zeros((len(curves), modes, longest))
        self.points = np.zeros(len(curves), dtype=np.int64)
        projections: dict[bytes, FloatArray] = {}
        for k, curve in enumerate(curves):
            if curve is None:
                continue
            use = curve.s_m <= end_m * PAST_THE_END
            s = np.minimum(curve.s_m[use], end_m)
            self.points[k] = n = len(s)
            self.s_m[k, n:] = s[-1]
            self.s_m[k, :n] = s
            self.x_m[k, :n], self.y_m[k, :n] = curve.x_m[use], curve.y_m[use]
            if s.tobytes() not in projections:
                projections[s.tobytes()] = projection(s, modes)
            self.project[k, :, :n] = projections[s.tobytes()]


def projection(s: FloatArray, modes: int) -> FloatArray:
    """From values at s to coefficients of Legendre polynomials of unit mean square: (modes, n)."""
    t = 2.0 * s / s[-1] - 1.0
    count = min(modes, len(s))
    V = legendre.legvander(t, count - 1) * np.sqrt(2.0 * np.arange(count) + 1.0)
    result = np.zeros((modes, len(s)))
    result[:count] = np.linalg.pinv(V)
    return result
