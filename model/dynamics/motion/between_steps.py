"""Coefficients between the ends of steps: cubic, from their values and rates there."""

from __future__ import annotations

import numpy as np

from model.measurements import FloatArray


def between_steps(
    ends_s: FloatArray, q: FloatArray, rate: FloatArray, times_s: FloatArray
) -> FloatArray:
    """Return coefficients (T, N) at `times_s`, from those at the ends (n, N) of the steps."""
    if len(ends_s) == 1:
        return np.repeat(q, len(times_s), axis=0)
    last = np.clip(np.searchsorted(ends_s, times_s, "right") - 1, 0, len(ends_s) - 2)
    h = (ends_s[last + 1] - ends_s[last])[:, None]
    u = (times_s - ends_s[last])[:, None] / h
    begin, end = q[last], q[last + 1]
    bend = u * (1.0 - u)
    away = (1.0 - u) * (h * rate[last] - (end - begin)) - u * (h * rate[last + 1] - (end - begin))
    return np.asarray(begin + u * (end - begin) + bend * away)
