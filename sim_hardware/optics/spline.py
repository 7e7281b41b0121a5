"""The cubic spline through a curve's samples, compiled: scipy's takes sixty times longer to set up.

Import this where it is used.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim_hardware.jit import brief_jit

Floats = npt.NDArray[np.float64]


@brief_jit
def spline(s: Floats, points: Floats, at: Floats) -> Floats:
    """Return the cubic spline through points (n, 2) at parameters `s` (n), at rising `at`: (m, 2).

    Its third derivative is continuous at the last points but one, too ("not a knot"); through
    three points it is a parabola, through two a straight line.
    """
    slope = _spline_slopes(s, points)
    result = np.empty((at.shape[0], 2))
    k = 0
    for i in range(at.shape[0]):
        while k < s.shape[0] - 2 and at[i] > s[k + 1]:
            k += 1
        width = s[k + 1] - s[k]
        t = (at[i] - s[k]) / width
        for c in range(2):
            rise = points[k + 1, c] - points[k, c]
            first, last = slope[k, c] * width - rise, rise - slope[k + 1, c] * width
            bend = (1.0 - t) * first + t * last
            result[i, c] = points[k, c] + t * rise + t * (1.0 - t) * bend
    return result


@brief_jit
def _spline_slopes(s: Floats, points: Floats) -> Floats:
    """Slopes (n, 2) at the points, from the tridiagonal equations of the spline."""
    n = s.shape[0]
    slope = np.empty((n, 2))
    if n < 4:
        return _few_slopes(s, points, slope)
    diagonal, above = np.empty(n), np.empty(n)
    first, second = s[1] - s[0], s[2] - s[1]
    last, before = s[n - 1] - s[n - 2], s[n - 2] - s[n - 3]
    diagonal[0], above[0] = second, first + second
    for c in range(2):
        left, right = (points[1, c] - points[0, c]) / first, (points[2, c] - points[1, c]) / second
        both = first + second
        slope[0, c] = ((first + 2.0 * both) * second * left + first * first * right) / both
    for k in range(1, n):
        if k == n - 1:
            below, middle, higher = last + before, before, 0.0
        else:
            below, higher = s[k + 1] - s[k], s[k] - s[k - 1]
            middle = 2.0 * (below + higher)
        factor = below / diagonal[k - 1]
        diagonal[k], above[k] = middle - factor * above[k - 1], higher
        for c in range(2):
            here = (points[k, c] - points[k - 1, c]) / (s[k] - s[k - 1])
            if k == n - 1:
                there, both = (points[k - 1, c] - points[k - 2, c]) / before, last + before
                right_side = (last * last * there + (2.0 * both + last) * before * here) / both
            else:
                there = (points[k + 1, c] - points[k, c]) / (s[k + 1] - s[k])
                right_side = 3.0 * (below * here + higher * there)
            slope[k, c] = right_side - factor * slope[k - 1, c]
    for c in range(2):
        slope[n - 1, c] /= diagonal[n - 1]
        for k in range(n - 2, -1, -1):
            slope[k, c] = (slope[k, c] - above[k] * slope[k + 1, c]) / diagonal[k]
    return slope


@brief_jit
def _few_slopes(s: Floats, points: Floats, slope: Floats) -> Floats:
    """Slopes of the parabola through three points, or of the line through two."""
    for c in range(2):
        here = (points[1, c] - points[0, c]) / (s[1] - s[0])
        if s.shape[0] == 2:
            slope[0, c] = slope[1, c] = here
            continue
        there = (points[2, c] - points[1, c]) / (s[2] - s[1])
        bend = (there - here) / (s[2] - s[0])
        slope[0, c] = here - bend * (s[1] - s[0])
        slope[1, c] = here + bend * (s[1] - s[0])
        slope[2, c] = there + bend * (s[2] - s[1])
    return slope
