"""Readings about a robust line in time."""

from __future__ import annotations

import numpy as np

from model.measurements import FloatArray

PER_MAD = 1.4826  # standard deviation of Gaussian noise over its median absolute deviation


def off_line(values: FloatArray) -> FloatArray:
    """Return distances from a robust line (Theil 1950, Sen 1968)."""
    if len(values) < 2:
        return np.zeros(len(values))
    t = np.arange(len(values), dtype=float)
    i, j = np.triu_indices(len(values), 1)
    slope = float(np.median((values[j] - values[i]) / (t[j] - t[i])))
    off = values - slope * t
    return np.asarray(off - np.median(off))


def robust_sd(off: FloatArray) -> float:
    """Return the standard deviation from the median absolute distance."""
    return PER_MAD * float(np.median(np.abs(off)))
