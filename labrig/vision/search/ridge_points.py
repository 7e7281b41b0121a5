"""Measure sub-pixel ridge points: middle, height and width of a band across a line of pixels."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]


@jit
def _largest(reach: IntArray) -> int:
    most = 0
    for r in reach:
        most = max(most, r)
    return most


@jit
def ridge_offsets(
    smooth: MapArray,
    u: FloatArray,
    v: FloatArray,
    along_u: FloatArray,
    along_v: FloatArray,
    reach: IntArray,
    sign: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the offset of the ridge nearest to each point, its height and full width at half.

    In steps of (along_u, along_v), looked for within `reach` (points,) steps. The offset is the
    middle between the two places at half height, so thin and thick bands are measured alike; NaN
    where there is none. The height is counted from the mean of the two ends.
    """
    rows, columns = smooth.shape
    n = len(u)
    offset, width = np.full(n, np.nan), np.full(n, np.nan)
    height = np.zeros(n)
    profile = np.empty(2 * _largest(reach) + 1)
    for i in range(n):
        r = reach[i]
        inside = True
        for q in range(-r, r + 1):
            a, b = u[i] + q * along_u[i], v[i] + q * along_v[i]
            col, row = math.floor(a), math.floor(b)
            if row < 0 or col < 0 or row >= rows - 1 or col >= columns - 1:
                inside = False
                break
            fa, fb = a - col, b - row
            profile[q + r] = sign * (
                (smooth[row, col] * (1 - fa) + smooth[row, col + 1] * fa) * (1 - fb)
                + (smooth[row + 1, col] * (1 - fa) + smooth[row + 1, col + 1] * fa) * fb
            )
        if not inside:
            continue
        floor = 0.5 * (profile[0] + profile[2 * r])
        best, where = 0.0, 0
        for q in range(1, 2 * r):
            if profile[q] >= profile[q - 1] and profile[q] >= profile[q + 1]:
                worth = (profile[q] - floor) * (1.0 - 0.5 * abs(q - r) / r)
                if worth > best:
                    best, where = worth, q
        if where == 0:
            continue
        half = floor + 0.5 * (profile[where] - floor)
        left = where
        while left > 0 and profile[left] > half:
            left -= 1
        right = where
        while right < 2 * r and profile[right] > half:
            right += 1
        if profile[left] > half or profile[right] > half:
            continue
        low = left + (half - profile[left]) / (profile[left + 1] - profile[left])
        high = right - (half - profile[right]) / (profile[right - 1] - profile[right])
        offset[i] = 0.5 * (low + high) - r
        width[i] = high - low
        height[i] = profile[where] - floor
    return offset, height, width
