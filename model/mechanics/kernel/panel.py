"""One panel: everything at its nodes, its matrix and right-hand sides, what goes on to the next."""

# ruff: noqa: C901  (calls that numba does not inline cost more than they explain)
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from model.jit import Array, jit


class Work(NamedTuple):
    """Scratch arrays of one thread."""

    ends: Array  # (3, C) answers of psi, a, b at the panel's clamp side
    start: Array  # (3, C) the same at its contact side
    J: Array  # (n, n)
    rhs: Array  # (n, C)
    cos: Array  # (n,) of psi, and so on
    sin: Array
    a: Array
    soft: Array  # c(s) = B/B(s)
    slope: Array  # dc/ds
    k: Array  # free curvature
    K: Array  # its integral from the node to the panel's top
    T: Array  # A @ (c a)
    Ac: Array  # A @ c
    back: Array  # b @ diag(c) @ A
    move: Array  # how the collocation equations change when the top moves


@jit
def new_work(n: int, columns: int) -> Work:
    """Scratch arrays for n nodes."""
    return Work(
        ends=np.zeros((3, columns)), start=np.zeros((3, columns)), J=np.zeros((n, n)),
        rhs=np.zeros((n, columns)), cos=np.zeros(n), sin=np.zeros(n), a=np.zeros(n),
        soft=np.ones(n), slope=np.zeros(n), k=np.zeros(n), K=np.zeros(n), T=np.zeros(n),
        Ac=np.zeros(n), back=np.zeros(n), move=np.zeros(n),
    )  # fmt: skip


@jit
def polynomial(row: Array, t: float, half: float) -> tuple[float, float, float]:
    """Value, integral over s from t = 0, and slope d/ds of a panel's polynomial at t."""
    value, integral, slope = 0.0, 0.0, 0.0
    for d in range(len(row) - 1, -1, -1):
        slope = slope * t + value
        value = value * t + row[d]
        integral = integral * t + row[d] / (d + 1)
    return value, integral * t * half, slope / half


@jit
def is_nonzero(row: Array) -> bool:
    """Return whether a panel's polynomial is not 0: most parameters change k*(s) or c(s) alone."""
    for d in range(len(row)):  # noqa: SIM110 - numba has no generators
        if row[d] != 0.0:
            return True
    return False


@jit
def evaluate(
    rule: Any, kappa: Array, soft: Array, psi: Array, t_top: float, half: float, h: float,
    a_top: float, w: Work,
) -> tuple[float, float]:  # fmt: skip
    """Everything at the nodes of a panel; returns k* at its top and its integral over the panel."""
    n = len(rule.c)
    k_top, K_top, _ = polynomial(kappa, t_top, half)
    _, K_bottom, _ = polynomial(kappa, t_top - h / half, half)
    for j in range(n):
        t = t_top - h * rule.c[j] / half
        w.k[j], K, _ = polynomial(kappa, t, half)
        w.K[j] = K_top - K
        w.cos[j], w.sin[j] = np.cos(psi[j]), np.sin(psi[j])
        if len(soft) > 0:
            w.soft[j], _, w.slope[j] = polynomial(soft, t, half)
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += rule.A[i, j] * w.cos[j]
        w.a[i] = a_top + h * total
    uniform = len(soft) == 0
    for i in range(n):
        total, softs = 0.0, rule.c[i]
        if uniform:
            for j in range(n):
                total += rule.A[i, j] * w.a[j]
        else:
            softs = 0.0
            for j in range(n):
                total += rule.A[i, j] * w.soft[j] * w.a[j]
                softs += rule.A[i, j] * w.soft[j]
        w.T[i], w.Ac[i] = total, softs
    return k_top, K_top - K_bottom


@jit
def matrix(rule: Any, uniform: bool, scale: float, w: Work) -> None:
    """J = 1 + nu h^2 A diag(c) A diag(sin psi), and b diag(c) A."""
    n = len(rule.c)
    if uniform:
        for i in range(n):
            w.back[i] = rule.bA[i]
            for k in range(n):
                w.J[i, k] = scale * rule.A2[i, k] * w.sin[k]
            w.J[i, i] += 1.0
        return
    for k in range(n):
        total = 0.0
        for j in range(n):
            total += rule.b[j] * w.soft[j] * rule.A[j, k]
        w.back[k] = total
        for i in range(n):
            total = 0.0
            for j in range(n):
                total += rule.A[i, j] * w.soft[j] * rule.A[j, k]
            w.J[i, k] = scale * total * w.sin[k]
        w.J[k, k] += 1.0


@jit
def moving_top(rule: Any, nu: float, h: float, a_top: float, k_top: float, w: Work) -> float:
    """How the equations change with the top, the bottom held; returned: psi at the end."""
    n = len(rule.c)
    end = -k_top
    for i in range(n):
        total = 0.0
        for j in range(n):
            rate = w.soft[j] * (2.0 * w.a[j] - a_top) + h * w.slope[j] * (1.0 - rule.c[j]) * w.a[j]
            total += rule.A[i, j] * rate
        w.move[i] = k_top - w.k[i] * (1.0 - rule.c[i]) - nu * total
        rate = w.soft[i] * (2.0 * w.a[i] - a_top) + h * w.slope[i] * (1.0 - rule.c[i]) * w.a[i]
        end += nu * rule.b[i] * rate
    return end


@jit
def parameter_columns(
    rule: Any, nu: float, h: float, t_top: float, half: float, dkappa: Array, dsoft: Array, w: Work
) -> None:
    """Add to the right-hand sides what a change of k*(s) and c(s) does; (Q, D) rows of this panel.

    What they do to psi at the panel's end goes to `w.ends[0]`.
    """
    n = len(rule.c)
    for q in range(len(dkappa)):
        w.ends[0, 2 + q] = 0.0
        if is_nonzero(dkappa[q]):
            _, K_top, _ = polynomial(dkappa[q], t_top, half)
            _, K_bottom, _ = polynomial(dkappa[q], t_top - h / half, half)
            w.ends[0, 2 + q] = K_bottom - K_top
            for i in range(n):
                _, K, _ = polynomial(dkappa[q], t_top - h * rule.c[i] / half, half)
                w.rhs[i, 2 + q] += K - K_top
        if is_nonzero(dsoft[q]):
            for j in range(n):
                dc, _, _ = polynomial(dsoft[q], t_top - h * rule.c[j] / half, half)
                w.ends[0, 2 + q] += nu * h * rule.b[j] * dc * w.a[j]
                for i in range(n):
                    w.rhs[i, 2 + q] += nu * h * rule.A[i, j] * dc * w.a[j]


@jit
def solve_in_place(J: Array, rhs: Array) -> None:
    """Gauss elimination with row exchange of J x = rhs; x replaces rhs."""
    n, columns = rhs.shape
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(J[i, k]) > abs(J[best, k]):
                best = i
        if best != k:
            for j in range(k, n):
                J[k, j], J[best, j] = J[best, j], J[k, j]
            for j in range(columns):
                rhs[k, j], rhs[best, j] = rhs[best, j], rhs[k, j]
        inverse = 1.0 / J[k, k]
        for i in range(k + 1, n):
            factor = J[i, k] * inverse
            for j in range(k + 1, n):
                J[i, j] -= factor * J[k, j]
            for j in range(columns):
                rhs[i, j] -= factor * rhs[k, j]
    for k in range(n - 1, -1, -1):
        inverse = 1.0 / J[k, k]
        for j in range(columns):
            total = rhs[k, j]
            for i in range(k + 1, n):
                total -= J[k, i] * rhs[i, j]
            rhs[k, j] = total * inverse


@jit
def pass_on(rule: Any, nu: float, h: float, w: Work) -> tuple[float, float, float]:
    """From solved nodes to the panel's end: answers into `w.ends`; b.(c a), b.cos, b.sin returned.

    `w.ends[0]` holds what acts on psi at the end directly.
    """
    n, columns = w.rhs.shape
    moment, run, rise, softs = 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        moment += rule.b[j] * w.soft[j] * w.a[j]
        run += rule.b[j] * w.cos[j]
        rise += rule.b[j] * w.sin[j]
        softs += rule.b[j] * w.soft[j]
    for q in range(columns):
        turn, dx, dy = 0.0, 0.0, 0.0
        for j in range(n):
            turn += w.back[j] * w.sin[j] * w.rhs[j, q]
            dx += rule.b[j] * w.sin[j] * w.rhs[j, q]
            dy += rule.b[j] * w.cos[j] * w.rhs[j, q]
        w.ends[0, q] += w.start[0, q] + nu * h * (softs * w.start[1, q] - h * turn)
        w.ends[1, q] += w.start[1, q] - h * dx
        w.ends[2, q] += w.start[2, q] + h * dy
    w.ends[0, 0] += h * moment
    return moment, run, rise


@jit
def panel_of(breaks: Array, s: float) -> int:
    """Return the panel that begins before s and does not end before it."""
    m = len(breaks) - 2
    while m > 0 and breaks[m] >= s:
        m -= 1
    return m


@jit
def restart(w: Work) -> None:
    """Copy the sensitivities at the end of one panel to the start of the next."""
    for j in range(w.ends.shape[1]):
        for i in range(3):
            w.start[i, j] = w.ends[i, j]
            w.ends[i, j] = 0.0
