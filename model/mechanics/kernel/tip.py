"""The free-ended sheet under a force at its tip: see `model/mechanics/tip_load.py`.

Backward from the tip, panel by panel: psi' = -(k* + c (a n - b t)), a' = cos psi, b' = sin psi,
with (t, n) the components of the force over B in the tip's frame. Columns: the tip's angle, and the
Newton residual.
"""

# ruff: noqa: C901  (calls that numba does not inline cost more than they explain)
from __future__ import annotations

from typing import Any

import numpy as np

from model.jit import Array, jit
from model.mechanics.kernel.panel import polynomial, solve_in_place

MOST_STEPS = 12
SMALL_STEP = 1e-8
FAR_RAD = 1.0  # of the tip in one step of the load


@jit
def components(
    force: tuple[float, float], follows: bool, tip: float
) -> tuple[float, float, float, float]:
    """Return the force along and across the tip, and their derivatives by the tip's angle."""
    if follows:
        return force[0], force[1], 0.0, 0.0
    t = force[0] * np.cos(tip) + force[1] * np.sin(tip)
    n = force[1] * np.cos(tip) - force[0] * np.sin(tip)
    return t, n, n, -t


@jit
def panel(
    rule: Any, kappa: Array, soft: Array, load: tuple[float, float, float, float], h: float,
    psi: Array, state: Array, to: Array, columns: Array, places: Array, J: Array, rows: Array,
    lever: Array,
) -> None:  # fmt: skip
    """Linearise one panel: state (psi, a, b) and how it answers, `to` (3, 2), from end to end.

    `columns` (n, 2) receives how psi answers, `places` (n, 2) a and b at the nodes; J (n, n),
    rows (5, n) and lever (n + 1, 3) are scratch.
    """
    t, n_, dt, dn = load
    m = len(psi)
    c, turn, cos, sin, push = rows[0], rows[1], rows[2], rows[3], rows[4]
    _, top, _ = polynomial(kappa, 1.0, 0.5 * h)
    _, bottom, _ = polynomial(kappa, -1.0, 0.5 * h)
    for j in range(m):
        _, at, _ = polynomial(kappa, 1.0 - 2.0 * rule.c[j], 0.5 * h)
        turn[j], c[j] = top - at, 1.0
        if len(soft) > 0:
            c[j], _, _ = polynomial(soft, 1.0 - 2.0 * rule.c[j], 0.5 * h)
        cos[j], sin[j] = np.cos(psi[j]), np.sin(psi[j])
    for i in range(m):
        a, b = state[1], state[2]
        for j in range(m):
            a += h * rule.A[i, j] * cos[j]
            b += h * rule.A[i, j] * sin[j]
        places[i, 0], places[i, 1] = a, b
        push[i] = c[i] * (a * n_ - b * t)
    for i in range(m + 1):  # A, and b, times c, c (a dn - b dt), c (a n - b t)
        lever[i, 0] = lever[i, 1] = lever[i, 2] = 0.0
        for j in range(m):
            weight = rule.A[i, j] if i < m else rule.b[j]
            lever[i, 0] += weight * c[j]
            lever[i, 1] += weight * c[j] * (places[j, 0] * dn - places[j, 1] * dt)
            lever[i, 2] += weight * push[j]
    uniform = len(soft) == 0
    for k in range(m):
        swing = h * h * (n_ * sin[k] + t * cos[k])
        for i in range(m):
            total = rule.A2[i, k]
            if not uniform:
                total = 0.0
                for j in range(m):
                    total += rule.A[i, j] * c[j] * rule.A[j, k]
            J[i, k] = (1.0 if i == k else 0.0) - total * swing
    for i in range(m):
        for q in range(2):
            tilt = n_ * to[1, q] - t * to[2, q]
            columns[i, q] = to[0, q] - h * lever[i, 0] * tilt
        columns[i, 0] -= h * lever[i, 1]
        columns[i, 1] -= psi[i] - state[0] + turn[i] + h * lever[i, 2]
    solve_in_place(J, columns)
    for q in range(2):
        swung, dx, dy = 0.0, 0.0, 0.0
        for k in range(m):
            back = rule.bA[k]
            if not uniform:
                back = 0.0
                for j in range(m):
                    back += rule.b[j] * c[j] * rule.A[j, k]
            swung += back * (n_ * sin[k] + t * cos[k]) * columns[k, q]
            dx += rule.b[k] * sin[k] * columns[k, q]
            dy += rule.b[k] * cos[k] * columns[k, q]
        tilt = n_ * to[1, q] - t * to[2, q]
        to[0, q] += h * (h * swung - lever[m, 0] * tilt)
        to[1, q] -= h * dx
        to[2, q] += h * dy
    to[0, 0] -= h * lever[m, 1]
    state[0] -= (top - bottom) + h * lever[m, 2]
    for j in range(m):
        state[1] += h * rule.b[j] * cos[j]
        state[2] += h * rule.b[j] * sin[j]


@jit
def newton(
    breaks: Array, kappa: Array, soft: Array, rule: Any, force: tuple[float, float],
    follows: bool, psi: Array, tip: float, places: Array, end: Array,
) -> tuple[bool, float]:  # fmt: skip
    """Improve psi (P, n) in place; returns whether it converged, and the tip's angle.

    places (P, n, 2) and end (2,) are a and b at the nodes and at the clamp.
    """
    P, n = psi.shape
    columns, state, to = np.zeros((P, n, 2)), np.zeros(3), np.zeros((3, 2))
    J, rows, lever, done = np.zeros((n, n)), np.zeros((5, n)), np.zeros((n + 1, 3)), False
    for _ in range(MOST_STEPS):
        load = components(force, follows, tip)
        for i in range(3):
            state[i] = to[i, 0] = to[i, 1] = 0.0
        for p in range(P - 1, -1, -1):
            h = breaks[p + 1] - breaks[p]
            panel(
                rule=rule, kappa=kappa[p], soft=soft[p], load=load, h=h, psi=psi[p], state=state,
                to=to, columns=columns[p], places=places[p], J=J, rows=rows, lever=lever,
            )  # fmt: skip
        end[0], end[1] = state[1], state[2]
        if done:
            return True, tip
        turned = -(tip + state[0] + to[0, 1]) / (1.0 + to[0, 0])
        largest = abs(turned)
        for p in range(P):
            for i in range(n):
                columns[p, i, 1] += turned * columns[p, i, 0]
                largest = max(largest, abs(columns[p, i, 1]))
        if not largest < 1e9:
            return False, tip
        scale = min(1.0, 0.5 / max(largest, 1e-12))
        for p in range(P):
            for i in range(n):
                psi[p, i] += scale * columns[p, i, 1]
        tip += scale * turned
        done = largest < SMALL_STEP
    return False, tip


@jit
def grow(
    breaks: Array, kappa: Array, soft: Array, rule: Any, along: float, across: float,
    follows: bool, first: float, out: Array,
) -> tuple[bool, float]:  # fmt: skip
    """Let the load grow from the free shape, so that what is found is reached from rest.

    `first` is the share of the load to begin with; a step that turns the tip far is taken in parts.

    out (3, P n + 1): s, x, y at the nodes, descending from the tip; then s of the clamp, and x, y
    of the tip. Returns whether all converged, and the tip's angle.
    """
    P, n = len(breaks) - 1, len(rule.c)
    psi, places, end, phi = np.zeros((P, n)), np.zeros((P, n, 2)), np.zeros(2), 0.0
    for p in range(P - 1, -1, -1):
        h = breaks[p + 1] - breaks[p]
        _, top, _ = polynomial(kappa[p], 1.0, 0.5 * h)
        _, bottom, _ = polynomial(kappa[p], -1.0, 0.5 * h)
        for j in range(n):
            _, at, _ = polynomial(kappa[p], 1.0 - 2.0 * rule.c[j], 0.5 * h)
            psi[p, j] = phi - (top - at)
        phi -= top - bottom
    tip, at, share, kept = -phi, 0.0, first, psi.copy()
    while at < 1.0:
        aim = min(1.0, at + share)
        force = (along * aim, across * aim)
        good, turned = newton(
            breaks=breaks,
            kappa=kappa,
            soft=soft,
            rule=rule,
            force=force,
            follows=follows,
            psi=psi,
            tip=tip,
            places=places,
            end=end,
        )
        if good and abs(turned - tip) < FAR_RAD:
            at, tip = aim, turned
            kept[:] = psi
        else:
            share *= 0.5
            psi[:] = kept
            if share < 1e-4 * first:
                return False, tip
    cos, sin = np.cos(tip), np.sin(tip)
    for p in range(P):
        for j in range(n):
            k, a, b = (P - 1 - p) * n + j, end[0] - places[p, j, 0], end[1] - places[p, j, 1]
            out[0, k] = breaks[p + 1] - (breaks[p + 1] - breaks[p]) * rule.c[j]
            out[1, k], out[2, k] = cos * a - sin * b, sin * a + cos * b
    out[1, P * n] = cos * end[0] - sin * end[1]
    out[2, P * n] = sin * end[0] + cos * end[1]
    return True, tip
