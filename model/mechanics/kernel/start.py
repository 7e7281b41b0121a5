"""Where Newton begins: the free shape, bent by the force it takes to hold it."""

from __future__ import annotations

from typing import Any

import numpy as np

from model.jit import Array, jit, jit_inside
from model.mechanics.kernel.newton import newton
from model.mechanics.kernel.panel import Work, panel_of, polynomial


@jit
def free_angle(breaks: Array, kappa: Array, p: int, s: float, phi: float) -> float:
    """Phi of the free shape at s in panel p, phi being that at the panel's beginning."""
    half = 0.5 * (breaks[p + 1] - breaks[p])
    _, low, _ = polynomial(kappa[p], -1.0, half)
    _, high, _ = polynomial(kappa[p], (s - breaks[p]) / half - 1.0, half)
    return phi + high - low


@jit
def free_step(
    breaks: Array, kappa: Array, rule: Any, p: int, phi: float, s: float, end: float
) -> tuple[float, float]:
    """Follow the free shape from s to end, both in panel p."""
    x, y = 0.0, 0.0
    for j in range(len(rule.c)):
        angle = free_angle(breaks, kappa, p, s + (end - s) * rule.c[j], phi)
        x += rule.b[j] * np.cos(angle)
        y += rule.b[j] * np.sin(angle)
    return x * (end - s), y * (end - s)


@jit
def free_crossing(breaks: Array, kappa: Array, rule: Any, R: float) -> tuple[float, float]:
    """Where the free shape, or the ray it ends in, first meets the arc: s_hat and polar angle.

    Good to a hundredth of R: a start for Newton. |r(s)| <= s: the arc cannot be met before s = R.
    """
    s, x, y, phi, root = 0.0, 0.0, 0.0, 0.0, 0.0
    for p in range(len(breaks) - 1):
        while s < breaks[p + 1] and (s < R or R - np.hypot(x, y) > 0.02 * R):
            reach = R if s < R else s + R - np.hypot(x, y)  # never beyond the first crossing
            end = min(reach, breaks[p + 1])
            dx, dy = free_step(breaks, kappa, rule, p, root, s, end)
            s, x, y = end, x + dx, y + dy
        phi = free_angle(breaks, kappa, p, s, root)
        if s < breaks[p + 1]:
            break
        root = phi
    forward = x * np.cos(phi) + y * np.sin(phi)
    missing = R * R - x * x - y * y
    step = missing / (forward + np.sqrt(max(forward * forward + missing, 0.0)) + 1e-300)
    if s < breaks[-1]:
        step = min(step, 0.1 * R)
    x, y = x + step * np.cos(phi), y + step * np.sin(phi)
    return s + step, np.arctan2(y, x)


@jit
def free_start(breaks: Array, kappa: Array, rule: Any, s_hat: float, psi: Array) -> None:
    """Fill psi with the free shape seen from its contact."""
    top, phi = min(s_hat, breaks[-1]), 0.0
    contact = panel_of(breaks, top)
    for p in range(len(psi)):
        end = min(top, breaks[p + 1]) if p <= contact else breaks[p]
        for j in range(len(rule.c)):
            s = breaks[p] + (end - breaks[p]) * (1.0 - rule.c[j])
            psi[p, j] = free_angle(breaks, kappa, p, s, phi)
        phi = free_angle(breaks, kappa, p, end, phi)
    for p in range(len(psi)):
        for j in range(len(rule.c)):
            psi[p, j] = psi[p, j] - phi if p <= contact else 0.0


@jit
def bent_start(breaks: Array, rule: Any, x: Array, psi: Array) -> None:
    """Bend the free shape by the force's moment with the lever of a straight sheet."""
    top = min(x[1], breaks[-1])
    for p in range(panel_of(breaks, top) + 1):
        h = min(top, breaks[p + 1]) - breaks[p]
        for j in range(len(rule.c)):
            lever = x[1] - breaks[p] - h * (1.0 - rule.c[j])
            psi[p, j] += 0.5 * x[0] * (lever * lever - (x[1] - top) ** 2)


@jit_inside
def cold(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, reach: float,
    angle: float, psi: Array, x: Array, columns: Array, w: Work,
) -> int:  # fmt: skip
    """Newton straight from the free shape. 0: did not converge, or not surely on its branch."""
    length = breaks[-1]
    s_free, free = free_crossing(breaks, kappa, rule, R)
    x[1] = s_free
    x[0] = 3.0 * (free - angle) / (R * R * (1.0 - max(0.0, 1.0 - length / R) ** 3))
    if length > s_free:  # about as long as an arc through the contact
        x[1] = R * (1.0 + angle * angle / 6.0)
    free_start(breaks, kappa, rule, x[1], psi)
    bent_start(breaks, rule, x, psi)
    steps, determinant = newton(
        breaks=breaks,
        kappa=kappa,
        soft=soft,
        rule=rule,
        R=R,
        angle=angle,
        psi=psi,
        x=x,
        columns=columns,
        w=w,
    )
    if x[1] <= length and reach <= length * (
        1.0 + 1e-9
    ):  # on the sheet there is never a second one
        return steps
    return steps if determinant > 0.0 and steps < 9 and abs(free - angle) < 1.0 else 0
