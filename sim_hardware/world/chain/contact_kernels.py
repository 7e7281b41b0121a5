"""The chain of links held by an object on the arc, compiled. Import this where it is used.

What touches the sheet at arc length s feels a curve rounded over a few links: link i counts with
the weight S(s/h - i), where S rises smoothly from 0 to 1. The curve is then three times
differentiable in s, and differs from the links' corners by O(h^2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sim_hardware.jit import brief_jit
from sim_hardware.world.chain.kernels import (
    LARGE_STEP_RAD,
    MOST_STEPS,
    NO_SOLUTION,
    NOT_A_MINIMUM,
    OFF_THE_SHEET,
    SMALL_STEP_RAD,
    SOLVED,
    Floats,
    Hinges,
    directions,
    eliminate,
    hinge_terms,
)


class ContactPoint(NamedTuple):
    """The point on the arc that touches the sheet."""

    x_m: float
    y_m: float
    offset_m: float  # from the neutral curve to the point on the arc, along the normal
    friction: (
        float  # coefficient, with the sign of the sliding; 0: the force is normal to the sheet
    )


@brief_jit
def _rise(x: float) -> tuple[float, float, float, float]:
    """S(x), 0 below -2 and 1 above 2: the integral of the cubic B-spline; three derivatives."""
    y = abs(x)
    if y >= 2.0:
        return (1.0 if x > 0.0 else 0.0), 0.0, 0.0, 0.0
    if y <= 1.0:
        above = 0.5 + y * (4.0 + y * y * (0.75 * y - 2.0)) / 6.0
        bump = (4.0 + y * y * (3.0 * y - 6.0)) / 6.0
        slope = 0.5 * y * (3.0 * y - 4.0)
        bend = 3.0 * y - 2.0
    else:
        left = 2.0 - y
        above = 1.0 - left**4 / 24.0
        bump = left**3 / 6.0
        slope = -0.5 * left * left
        bend = left
    if x < 0.0:
        return 1.0 - above, bump, -slope, bend
    return above, bump, slope, bend


@brief_jit
def touch(
    towards: Floats, s_m: float, h: float, offset: float
) -> tuple[float, float, float, float, float, float]:
    """Point of the arc that touches the sheet at s, its derivative by s, and the second one.

    `towards` (n, 2) are the directions of the links.
    """
    x = y = x1 = y1 = x2 = y2 = 0.0
    last = towards.shape[0] - 1
    for i in range(min(int(s_m / h) + 3, last) + 1):
        weight, bump, slope, bend = _rise(s_m / h - i)
        if i == 0:
            weight, bump, slope, bend = 0.5, 0.0, 0.0, 0.0
        cos, sin = towards[i, 0], towards[i, 1]
        a, d, dd = weight * h, slope / h, bend / (h * h)
        x += a * cos - offset * bump * sin
        y += a * sin + offset * bump * cos
        x1 += bump * cos - offset * d * sin
        y1 += bump * sin + offset * d * cos
        x2 += d * cos - offset * dd * sin
        y2 += d * sin + offset * dd * cos
    return x, y, x1, y1, x2, y2


@brief_jit
def _contact_terms(
    towards: Floats,
    contact: Floats,
    h: float,
    roll: ContactPoint,
    diagonal: Floats,
    work: Floats,
    rows: Floats,
) -> None:
    """Add what the object does to the links.

    `work` (n, 4): the residual moment of each link, and its derivatives by s and by the force on
    the sheet. `rows` (n,): derivative of the sliding condition by the links' angles.
    """
    s, fx, fy = contact[0], contact[1], contact[2]
    for i in range(towards.shape[0]):
        weight, bump, slope, _ = _rise(s / h - i)
        if i == 0:
            weight, bump, slope = 0.5, 0.0, 0.0
        a, b, d = weight * h, roll.offset_m * bump, roll.offset_m * slope / h
        cos, sin = towards[i, 0], towards[i, 1]
        ex, ey = -a * sin - b * cos, a * cos - b * sin
        ex1, ey1 = -bump * sin - d * cos, bump * cos - d * sin
        work[i, 0] -= fx * ex + fy * ey
        work[i, 1] = -(fx * ex1 + fy * ey1)
        work[i, 2] = -ex
        work[i, 3] = -ey
        diagonal[i] += fx * (a * cos - b * sin) + fy * (a * sin + b * cos)
        rows[i] = -(fx * (ex1 - roll.friction * ey1) + fy * (ey1 + roll.friction * ex1))


@brief_jit
def _border(
    diagonal: Floats, below: Floats, work: Floats, rows: Floats, small: Floats, right: Floats
) -> int:
    """Eliminate the links: leaves the 3 x 3 system `small`, `right` for s and the force.

    `work` becomes what the links answer to residual, s and force. Returns the negative pivots.
    """
    columns = np.empty((work.shape[0], 2))
    for i in range(work.shape[0]):
        columns[i, 0], columns[i, 1] = work[i, 2], work[i, 3]
    negative = eliminate(diagonal, below, work)
    for k in range(4):
        sliding = x = y = 0.0
        for i in range(rows.shape[0]):
            sliding += rows[i] * work[i, k]
            x += columns[i, 0] * work[i, k]
            y += columns[i, 1] * work[i, k]
        if k == 0:
            right[0], right[1], right[2] = right[0] - sliding, right[1] - x, right[2] - y
            continue
        small[0, k - 1] -= sliding
        small[1, k - 1] -= x
        small[2, k - 1] -= y
    return negative


@brief_jit
def solve_three(m: Floats, right: Floats, low: Floats, step: Floats) -> float:  # noqa: C901 - loops alone
    """Solve m step = right, 3 x 3, by elimination with exchange of rows; return the determinant.

    `low` (3, 4) is room to work in. (LAPACK's calls would take seconds to compile.)
    """
    determinant = 1.0
    for i in range(3):
        low[i, 3] = right[i]
        for j in range(3):
            low[i, j] = m[i, j]
    for k in range(3):
        best = k
        for i in range(k + 1, 3):
            if abs(low[i, k]) > abs(low[best, k]):
                best = i
        if best != k:
            determinant = -determinant
            for j in range(4):
                low[k, j], low[best, j] = low[best, j], low[k, j]
        determinant *= low[k, k]
        if not abs(determinant) > 0.0:
            return 0.0
        for i in range(k + 1, 3):
            share = low[i, k] / low[k, k]
            for j in range(k, 4):
                low[i, j] -= share * low[k, j]
    for i in range(2, -1, -1):
        total = low[i, 3]
        for j in range(i + 1, 3):
            total -= low[i, j] * step[j]
        step[i] = total / low[i, i]
    return determinant


@brief_jit
def _negative_eigenvalues(m: Floats, third: float) -> int:
    """Of a symmetric 3 x 3 matrix, by the signs of its leading minors; `third` is the last one."""
    first = m[0, 0]
    second = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    count = 0
    before = 1.0
    for minor in (first, second, third):
        if minor * before < 0.0:
            count += 1
        before = minor
    return count


@brief_jit
def relax_touched(
    phi: Floats, contact: Floats, hinges: Hinges, roll: ContactPoint, end_m: float
) -> int:
    """Bring the chain to rest with the roll holding it: least energy, the contact free to slide.

    `phi` (n,) and `contact` (s in m, and the force on the sheet over B, x and y, in 1/m^2) hold the
    start and, afterwards, the result. `end_m`: where the sheet, or its elongation, ends.
    """
    n = phi.shape[0]
    h = hinges.h_m
    diagonal, below, rows = np.empty(n), np.empty(n), np.empty(n)
    work, towards = np.empty((n, 4)), np.empty((n, 2))
    small, low = np.empty((3, 3)), np.empty((3, 4))
    right, step = np.empty(3), np.empty(3)
    for _ in range(MOST_STEPS):
        s, fx, fy = contact[0], contact[1], contact[2]
        directions(phi, towards)
        hinge_terms(phi, towards, hinges, work[:, 0], diagonal, below)
        _contact_terms(towards, contact, h, roll, diagonal, work, rows)
        x, y, x1, y1, x2, y2 = touch(towards, s, h, roll.offset_m)
        # The force has no component along the sheet, or, with friction, a given share there.
        qx, qy = x1 - roll.friction * y1, y1 + roll.friction * x1
        qx1, qy1 = x2 - roll.friction * y2, y2 + roll.friction * x2
        small[0, 0], small[0, 1], small[0, 2] = -(fx * qx1 + fy * qy1), -qx, -qy
        small[1, 0], small[1, 1], small[1, 2] = -x1, 0.0, 0.0
        small[2, 0], small[2, 1], small[2, 2] = -y1, 0.0, 0.0
        right[0], right[1], right[2] = -(fx * qx + fy * qy), roll.x_m - x, roll.y_m - y
        negative = _border(diagonal, below, work, rows, small, right)
        determinant = solve_three(small, right, low, step)
        if not abs(determinant) > 0.0:
            return NO_SOLUTION
        largest = abs(step[0]) / h * 1e-3
        for i in range(n):
            change = work[i, 0] - (
                work[i, 1] * step[0] + work[i, 2] * step[1] + work[i, 3] * step[2]
            )
            work[i, 0] = change
            largest = max(largest, abs(change))
        if not largest < LARGE_STEP_RAD:
            return NO_SOLUTION
        for i in range(n):
            phi[i] -= work[i, 0]
        for i in range(3):
            contact[i] -= step[i]
        if contact[0] > end_m or contact[0] < 4.0 * h:
            return OFF_THE_SHEET
        if largest < SMALL_STEP_RAD:
            # At a minimum under two constraints the bordered matrix has two negative eigenvalues.
            stable = (
                roll.friction != 0.0 or negative + _negative_eigenvalues(small, determinant) == 2
            )
            return SOLVED if stable else NOT_A_MINIMUM
    return NO_SOLUTION
