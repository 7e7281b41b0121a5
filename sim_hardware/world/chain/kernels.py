"""The chain of links at rest, compiled. Import this where it is used.

The chain: link 0 of length h/2 comes out of the clamp, links 1, 2, ... of length h follow. Hinge i
joins link i to the one before it (hinge 0: to the clamp), so hinge i >= 1 stands for the piece of
sheet around s = (i - 1/2) h, whose curvature is the hinge's angle over h. Everything is per bending
stiffness B: moments in 1/m, forces in 1/m^2, stiffnesses relative to B.

The functions keep the GIL: they run for microseconds.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim_hardware.jit import brief_jit

Floats = npt.NDArray[np.float64]

SOLVED, NO_SOLUTION, OFF_THE_SHEET, NOT_A_MINIMUM = 0, 1, 2, 3
# Newton's last step, after which the error is about its square.
SMALL_STEP_RAD = 1e-9
LARGE_STEP_RAD = 0.5
MOST_STEPS = 25


class Hinges(NamedTuple):
    """The hinges; the arrays have one entry a hinge, the clamp's first."""

    h_m: float
    rest_per_m: Floats  # k0
    drive_per_m: Floats  # Me/B
    stiffness: Floats  # relative to B
    stiffening: float  # relative gain of stiffness at large changes of curvature
    knee_per_m: float  # change of curvature at which half of it is there
    clamp_rad: float  # direction in which the clamp holds the sheet
    load_x_per_m2: Floats  # what lies beyond the hinge, itself included, weighs (N/B)
    load_y_per_m2: Floats


@brief_jit
def _moment(change: float, hinges: Hinges, i: int) -> tuple[float, float]:
    """Moment of a hinge at a change of curvature, and the derivative."""
    stiffness = hinges.stiffness[i]
    gain = hinges.stiffening
    if gain == 0.0:
        return stiffness * change, stiffness
    square = change * change
    knee = hinges.knee_per_m * hinges.knee_per_m
    below = square + knee
    slope = 1.0 + gain * square * (square + 3.0 * knee) / (below * below)
    return stiffness * change * (1.0 + gain * square / below), stiffness * slope


@brief_jit
def directions(phi: Floats, towards: Floats) -> None:
    """Cosine and sine of each link's angle, into `towards` (n, 2)."""
    for i in range(phi.shape[0]):
        towards[i, 0] = math.cos(phi[i])
        towards[i, 1] = math.sin(phi[i])


@brief_jit
def hinge_terms(
    phi: Floats,
    towards: Floats,
    hinges: Hinges,
    residual: Floats,
    diagonal: Floats,
    below: Floats,
) -> None:
    """Unbalanced moment of each link without a contact, and its tridiagonal derivative."""
    n = phi.shape[0]
    h = hinges.h_m
    for i in range(n):
        length = 0.5 * h if i == 0 else h
        cos, sin = towards[i, 0], towards[i, 1]
        load_x, load_y = hinges.load_x_per_m2[i], hinges.load_y_per_m2[i]
        residual[i] = -length * (load_y * cos - load_x * sin)
        diagonal[i] = length * (load_x * cos + load_y * sin)
        below[i] = 0.0
    for i in range(n):
        before = phi[i - 1] if i > 0 else hinges.clamp_rad
        change = (phi[i] - before) / h - hinges.rest_per_m[i]
        moment, slope = _moment(change, hinges, i)
        moment -= hinges.drive_per_m[i]
        residual[i] += moment
        diagonal[i] += slope / h
        if i > 0:
            residual[i - 1] -= moment
            diagonal[i - 1] += slope / h
            below[i] = -slope / h


@brief_jit
def eliminate(diagonal: Floats, below: Floats, right: Floats) -> int:
    """Solve the symmetric tridiagonal system in place for all columns; count negative pivots."""
    n, columns = right.shape
    negative = 0
    for i in range(n):
        if i > 0:
            factor = below[i] / diagonal[i - 1]
            diagonal[i] -= factor * below[i]
            for k in range(columns):
                right[i, k] -= factor * right[i - 1, k]
        if diagonal[i] < 0.0:
            negative += 1
    for i in range(n - 1, -1, -1):
        for k in range(columns):
            if i < n - 1:
                right[i, k] -= below[i + 1] * right[i + 1, k]
            right[i, k] /= diagonal[i]
    return negative


@brief_jit
def relax_free(phi: Floats, hinges: Hinges) -> int:
    """Bring the link angles `phi` (n,) to rest with nothing touching the sheet."""
    n = phi.shape[0]
    diagonal, below = np.empty(n), np.empty(n)
    step = np.empty((n, 1))
    towards = np.empty((n, 2))
    for _ in range(MOST_STEPS):
        directions(phi, towards)
        hinge_terms(phi, towards, hinges, step[:, 0], diagonal, below)
        negative = eliminate(diagonal, below, step)
        largest = total = 0.0  # no np.sum: to load numba's takes each process a tenth of a second
        for i in range(n):
            largest = max(largest, abs(step[i, 0]))
            total += step[i, 0]
        if not math.isfinite(total):
            return NO_SOLUTION
        # A load can turn the sheet far: the first steps are cut short.
        cut = 1.0 if largest <= LARGE_STEP_RAD else LARGE_STEP_RAD / largest
        for i in range(n):
            phi[i] -= cut * step[i, 0]
        if largest < SMALL_STEP_RAD:
            return SOLVED if negative == 0 else NOT_A_MINIMUM
    return NO_SOLUTION
