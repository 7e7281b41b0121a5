"""What touches a moving chain, compiled. Import this where it is used.

As for the chain at rest (`chain.contact_kernels`): at arc length s, link i counts with the integral
S(s/h - i) of a cubic B-spline. The last link goes on as the elongation and stands for all links
that would follow it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim_hardware.jit import brief_jit

Floats = npt.NDArray[np.float64]


@brief_jit
def rise(x: float) -> tuple[float, float]:
    """S(x), 0 below -2 and 1 above 2, and its derivative, the cubic B-spline."""
    y = abs(x)
    if y >= 2.0:
        return (1.0 if x > 0.0 else 0.0), 0.0
    if y <= 1.0:
        above = 0.5 + y * (4.0 + y * y * (0.75 * y - 2.0)) / 6.0
        bump = (4.0 + y * y * (3.0 * y - 6.0)) / 6.0
    else:
        above = 1.0 - (2.0 - y) ** 4 / 24.0
        bump = (2.0 - y) ** 3 / 6.0
    return (above if x >= 0.0 else 1.0 - above), bump


@brief_jit
def _weights(x: float, i: int, last: int) -> tuple[float, float]:
    """Weight of link i at x = s/h in link lengths, and its derivative by x."""
    if i == 0:
        return 0.5, 0.0
    if i < last:
        return rise(x - i)
    if x >= last + 2.0:
        return x - last + 0.5, 1.0
    weight = slope = 0.0
    for k in range(last, last + 4):
        above, bump = rise(x - k)
        weight += above
        slope += bump
    return weight, slope


@brief_jit
def touched(towards: Floats, s_m: float, h: float) -> tuple[float, float, float, float]:
    """Point of the chain at s, and the derivative by s. `towards` (n + 1, 2): links' directions."""
    last = towards.shape[0] - 1
    x = y = tx = ty = 0.0
    for i in range(min(last, int(s_m / h) + 2) + 1):
        weight, slope = _weights(s_m / h, i, last)
        x += weight * h * towards[i, 0]
        y += weight * h * towards[i, 1]
        tx += slope * towards[i, 0]
        ty += slope * towards[i, 1]
    return x, y, tx, ty


@brief_jit
def levers(towards: Floats, s_m: float, h: float, nx: float, ny: float, into: Floats) -> None:
    """How far the point at s moves along (nx, ny) as each link turns, into `into` (n + 1,), m."""
    last = towards.shape[0] - 1
    for i in range(last + 1):
        weight, _ = _weights(s_m / h, i, last)
        into[i] = weight * h * (ny * towards[i, 0] - nx * towards[i, 1])
