"""The root of a mean square, of what is known."""

from __future__ import annotations

import numpy as np

from model.measurements.data import FloatArray


def rms(values: FloatArray) -> float:
    """Return the root mean square of the finite values; NaN where there are none."""
    good = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(good**2))) if len(good) else float("nan")
