"""What several effects need: numbers that are not there count as nothing."""

from __future__ import annotations

import numpy as np

from model.measurements import FloatArray

MILLI = 1e-3  # mm to m, mN to N


def finite(values: FloatArray) -> FloatArray:
    """Return the values, 0 where there is none (no contact, no position)."""
    return np.where(np.isfinite(values), values, 0.0)
