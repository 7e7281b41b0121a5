"""How far a prediction has been off lately, and how much of that is noise."""

from __future__ import annotations

from collections import deque
from math import sqrt

import numpy as np

from drivers.interfaces import FloatArray

OVER_S = 10.0
_NORMAL = 0.6745  # median of |x| of the standard normal distribution


class RunningError:
    """Errors of the last `OVER_S` of a run."""

    def __init__(self) -> None:
        self._errors: deque[tuple[float, float]] = deque()

    def add(self, time_s: float, error: float) -> None:
        """Add one; what is no number is left out."""
        if np.isfinite(error):
            self._errors.append((time_s, error))
        while self._errors and self._errors[0][0] < time_s - OVER_S:
            self._errors.popleft()

    @property
    def rms(self) -> float | None:
        """Return the root of the mean square; None where there is nothing."""
        if not self._errors:
            return None
        return sqrt(sum(error**2 for _, error in self._errors) / len(self._errors))

    @property
    def mean(self) -> float | None:
        """Return the mean error."""
        if not self._errors:
            return None
        return sum(error for _, error in self._errors) / len(self._errors)


def white_noise(values: FloatArray) -> float:
    """Return the standard deviation of white noise in values (n,), by their differences."""
    known = values[np.isfinite(values)]
    if len(known) < 3:
        return 0.0
    return float(np.median(np.abs(np.diff(known)))) / (_NORMAL * sqrt(2.0))
