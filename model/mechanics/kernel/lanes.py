"""A panel sweep for many problems side by side: the last axis of every array is the lane.

The same algebra as `panel.py` and `newton.sweep`, written so that each innermost loop runs over the
lanes, which processors do several at a time. Problems differ in where their contact lies: panels
beyond it have the width 0. The elimination exchanges no rows, for the matrix is 1 and something
small; a problem for which that is not so ends among those that `batch.py` solves one by one.
"""

# ruff: noqa: C901  (calls that numba does not inline cost more than they explain)
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from model.jit import Array, jit


class Lanes(NamedTuple):
    """W problems and the scratch arrays of their solution."""

    kappa: Array  # (P, D, W)
    soft: Array  # (P, Dc, W)
    angle: Array  # (W,)
    nu: Array
    s_hat: Array
    phi_hat: Array
    psi: Array  # (P, n, W)
    columns: Array  # (P, n, 3, W) how psi answers to nu, s_hat, and the Newton residual
    ends: Array  # (3, 3, W) how psi, a, b at the panel's clamp side answer
    start: Array  # (3, 3, W) the same at its contact side
    at: Array  # (3, W) psi, a, b
    J: Array  # (n, n, W)
    cos: Array  # (n, W) of psi, and so on
    sin: Array
    a: Array
    push: Array  # c a
    T: Array  # A @ (c a)
    Ac: Array  # A @ c
    back: Array  # b @ diag(c) @ A
    move: Array  # A @ ((1 - theta) dc/ds a)
    c: Array
    slope: Array  # dc/ds
    k: Array
    K: Array  # integral of k from the node to the panel's top
    h: Array  # (W,) the panel's width
    moves: Array  # 1 where the panel's top is the contact and moves with it
    k_top: Array
    turn: Array  # integral of k over the panel
    moment: Array  # b @ (c a), and so on
    lurch: Array  # b @ ((1 - theta) dc/ds a)
    softs: Array
    run: Array
    rise: Array
    rows: Array  # (6, W) for a moment


@jit
def new_lanes(P: int, n: int, D: int, Dc: int, W: int) -> Lanes:
    """Room for W problems."""
    z = np.zeros
    return Lanes(
        kappa=z((P, D, W)), soft=z((P, Dc, W)), angle=z(W), nu=z(W), s_hat=z(W), phi_hat=z(W),
        psi=z((P, n, W)), columns=z((P, n, 3, W)), ends=z((3, 3, W)), start=z((3, 3, W)),
        at=z((3, W)), J=z((n, n, W)), cos=z((n, W)), sin=z((n, W)), a=z((n, W)), push=z((n, W)),
        T=z((n, W)), Ac=z((n, W)), back=z((n, W)), move=z((n, W)), c=np.ones((n, W)),
        slope=z((n, W)), k=z((n, W)), K=z((n, W)), h=z(W), moves=z(W), k_top=z(W), turn=z(W),
        moment=z(W), lurch=z(W), softs=z(W), run=z(W), rise=z(W), rows=z((6, W)),
    )  # fmt: skip


@jit
def polynomials(rows: Array, t: Array, half: float, value: Array, integral: Array) -> None:
    """Values of (D, W) at t, and integrals over s from t = 0."""
    D, W = rows.shape
    for m in range(W):
        value[m] = rows[D - 1, m]
        integral[m] = rows[D - 1, m] / D
    for d in range(D - 2, -1, -1):
        share = 1.0 / (d + 1)
        for m in range(W):
            value[m] = value[m] * t[m] + rows[d, m]
            integral[m] = integral[m] * t[m] + rows[d, m] * share
    for m in range(W):
        integral[m] *= t[m] * half


@jit
def slopes(rows: Array, t: Array, half: float, slope: Array) -> None:
    """d/ds of (D, W) at t."""
    D, W = rows.shape
    for m in range(W):
        slope[m] = 0.0
    for d in range(D - 1, 0, -1):
        for m in range(W):
            slope[m] = slope[m] * t[m] + d * rows[d, m] / half


@jit
def sines(x: Array, sin: Array, cos: Array) -> None:
    """Sine and cosine to the last digit but one, by the usual polynomials on [-pi/4, pi/4].

    In arithmetic alone, for calls of the library's functions would not run side by side.
    """
    for m in range(len(x)):
        q = np.floor(x[m] * 0.6366197723675814 + 0.5)
        r = x[m] - q * 1.5707963267948966
        z = r * r
        s = 2.75573136213857245213e-06 + z * (
            -2.50507477628578072866e-08 + z * 1.58962301576546568060e-10
        )
        s = 8.33333333332211858878e-03 + z * (-1.98412698295895385996e-04 + z * s)
        s = r + r * z * (-1.66666666666666307295e-01 + z * s)
        c = -2.75573141792967388112e-07 + z * (
            2.08757008419747316778e-09 - z * 1.13585365213876817300e-11
        )
        c = -1.38888888888730564116e-03 + z * (2.48015872888517045348e-05 + z * c)
        c = 1.0 - 0.5 * z + z * z * (4.16666666666665929218e-02 + z * c)
        half = np.floor(0.5 * q)
        odd = q - 2.0 * half  # 1 in the quadrants where sine and cosine change places
        sign = 1.0 - 2.0 * (half - 2.0 * np.floor(0.5 * half))
        sin[m] = sign * (s + odd * (c - s))
        cos[m] = sign * (c - odd * (c + s))


@jit
def weighted(weights: Array, rows: Array, out: Array) -> None:
    """Sum of weights (n,) times rows (n, W)."""
    for m in range(len(out)):
        out[m] = 0.0
    for j in range(len(weights)):
        weight, row = weights[j], rows[j]
        for m in range(len(out)):
            out[m] += weight * row[m]


@jit
def eliminate(J: Array, rhs: Array) -> None:
    """Solve J x = rhs (n, C, W) in place."""
    n, C, W = rhs.shape
    for k in range(n):
        pivot = J[k, k]
        for m in range(W):
            pivot[m] = 1.0 / pivot[m]
        for i in range(k + 1, n):
            factor = J[i, k]
            for m in range(W):
                factor[m] *= pivot[m]
            for j in range(k + 1, n):
                to, by = J[i, j], J[k, j]
                for m in range(W):
                    to[m] -= factor[m] * by[m]
            for q in range(C):
                to, by = rhs[i, q], rhs[k, q]
                for m in range(W):
                    to[m] -= factor[m] * by[m]
    for k in range(n - 1, -1, -1):
        pivot = J[k, k]
        for q in range(C):
            to = rhs[k, q]
            for i in range(k + 1, n):
                factor, by = J[k, i], rhs[i, q]
                for m in range(W):
                    to[m] -= factor[m] * by[m]
            for m in range(W):
                to[m] *= pivot[m]


@jit
def evaluate(breaks: Array, rule: Any, p: int, w: Lanes) -> None:
    """Everything at the nodes of panel p, whose contact sides are at w.at."""
    n, W = len(rule.c), len(w.nu)
    low, high, length = breaks[p], breaks[p + 1], breaks[-1]
    half = 0.5 * (high - low)
    t, t_top, value, ends = w.rows[0], w.rows[1], w.rows[2], w.rows[3]
    for m in range(W):
        top = min(w.s_hat[m], length)
        w.h[m] = max(min(top, high) - low, 0.0)
        inside = w.s_hat[m] < length and top <= high and (top > low or p == 0)
        w.moves[m] = 1.0 if inside else 0.0
        t_top[m] = w.h[m] / half - 1.0
        t[m] = -1.0
    polynomials(w.kappa[p], t, half, value, w.turn)
    polynomials(w.kappa[p], t_top, half, w.k_top, ends)
    for j in range(n):
        for m in range(W):
            t[m] = t_top[m] - w.h[m] * (rule.c[j] / half)
        K = w.K[j]
        polynomials(w.kappa[p], t, half, w.k[j], K)
        for m in range(W):
            K[m] = ends[m] - K[m]
        sines(w.psi[p, j], w.sin[j], w.cos[j])
        if w.soft.shape[1] > 0:
            polynomials(w.soft[p], t, half, w.c[j], value)
            slopes(w.soft[p], t, half, w.slope[j])
    for m in range(W):
        w.turn[m] = ends[m] - w.turn[m]
    for i in range(n):
        weighted(rule.A[i], w.cos, w.a[i])
        a, push, lag = w.a[i], w.push[i], 1.0 - rule.c[i]
        for m in range(W):
            a[m] = w.at[1, m] + w.h[m] * a[m]
            push[m] = w.c[i, m] * a[m]
            w.slope[i, m] *= lag * a[m]
    for i in range(n):
        weighted(rule.A[i], w.push, w.T[i])
        for m in range(W):
            w.Ac[i, m] = rule.c[i]
        if w.soft.shape[1] > 0:
            weighted(rule.A[i], w.c, w.Ac[i])
            weighted(rule.A[i], w.slope, w.move[i])
    weighted(rule.b, w.push, w.moment)
    weighted(rule.b, w.slope, w.lurch)
    weighted(rule.b, w.c, w.softs)
    weighted(rule.b, w.cos, w.run)
    weighted(rule.b, w.sin, w.rise)


@jit
def matrices(rule: Any, w: Lanes) -> None:
    """J = 1 + nu h^2 A diag(c) A diag(sin psi), and b diag(c) A."""
    n, W = len(rule.c), len(w.nu)
    factor, sums = w.rows[0], w.rows[1]
    for k in range(n):
        sin = w.sin[k]
        for m in range(W):
            factor[m] = w.nu[m] * w.h[m] * w.h[m] * sin[m]
        for m in range(W):
            w.back[k, m] = rule.bA[k]
        if w.soft.shape[1] > 0:
            weighted(rule.b * rule.A[:, k], w.c, w.back[k])
        for i in range(n):
            J, diagonal = w.J[i, k], 1.0 if i == k else 0.0
            if w.soft.shape[1] > 0:
                weighted(rule.A[i] * rule.A[:, k], w.c, sums)
                for m in range(W):
                    J[m] = diagonal + sums[m] * factor[m]
            else:
                weight = rule.A2[i, k]
                for m in range(W):
                    J[m] = diagonal + weight * factor[m]


@jit
def right_hand_sides(rule: Any, p: int, w: Lanes) -> None:
    """Compute the right-hand sides of the nodes: nu, s_hat, and the Newton residual."""
    n, W, at, start = len(rule.c), len(w.nu), w.at, w.start
    for i in range(n):
        T, Ac, K, k, psi, lag = w.T[i], w.Ac[i], w.K[i], w.k[i], w.psi[p, i], 1.0 - rule.c[i]
        by_nu, by_s, by_psi = w.columns[p, i, 0], w.columns[p, i, 1], w.columns[p, i, 2]
        for m in range(W):
            by_nu[m] = start[0, 0, m] + w.h[m] * (w.nu[m] * Ac[m] * start[1, 0, m] + T[m])
        for m in range(W):
            pull = 2.0 * T[m] + w.h[m] * w.move[i, m]
            by_s[m] = start[0, 1, m] + w.nu[m] * w.h[m] * Ac[m] * start[1, 1, m]
            by_s[m] -= w.moves[m] * (w.k_top[m] - k[m] * lag - w.nu[m] * pull)
        for m in range(W):
            by_psi[m] = start[0, 2, m] + w.nu[m] * w.h[m] * (Ac[m] * start[1, 2, m] + T[m])
            by_psi[m] -= psi[m] - at[0, m] + K[m]


@jit
def pass_on(rule: Any, p: int, w: Lanes) -> None:
    """From solved nodes to the panel's clamp side."""
    n, W, ends, start, at = len(rule.c), len(w.nu), w.ends, w.start, w.at
    for q in range(3):
        turn, dx, dy = w.rows[0], w.rows[1], w.rows[2]
        for m in range(W):
            turn[m] = dx[m] = dy[m] = 0.0
        for j in range(n):
            b, x, cos, sin, back = rule.b[j], w.columns[p, j, q], w.cos[j], w.sin[j], w.back[j]
            for m in range(W):
                turn[m] += back[m] * sin[m] * x[m]
            for m in range(W):
                dx[m] += b * sin[m] * x[m]
            for m in range(W):
                dy[m] += b * cos[m] * x[m]
        for m in range(W):
            lifted = w.softs[m] * start[1, q, m] - w.h[m] * turn[m]
            ends[0, q, m] = start[0, q, m] + w.nu[m] * w.h[m] * lifted
        for m in range(W):
            ends[1, q, m] = start[1, q, m] - w.h[m] * dx[m]
        for m in range(W):
            ends[2, q, m] = start[2, q, m] + w.h[m] * dy[m]
    for m in range(W):
        ends[0, 0, m] += w.h[m] * w.moment[m]
        pull = 2.0 * w.moment[m] + w.h[m] * w.lurch[m]
        ends[0, 1, m] += w.moves[m] * (w.nu[m] * pull - w.k_top[m])
        ends[1, 1, m] += w.moves[m] * w.run[m]
        ends[2, 1, m] += w.moves[m] * w.rise[m]
        at[0, m] += w.nu[m] * w.h[m] * w.moment[m] - w.turn[m]
        at[1, m] += w.h[m] * w.run[m]
        at[2, m] += w.h[m] * w.rise[m]


@jit
def at_contact(breaks: Array, w: Lanes) -> None:
    """Set the initial values of a sweep at the contact."""
    length = breaks[-1]
    for m in range(len(w.nu)):
        for i in range(3):
            w.at[i, m] = 0.0
            for q in range(3):
                w.ends[i, q, m] = 0.0
        w.at[1, m] = max(w.s_hat[m] - length, 0.0)
        w.ends[1, 1, m] = 0.0 if w.s_hat[m] < length else 1.0


@jit
def restart(w: Lanes) -> None:
    """Copy the sensitivities at the end of one panel to the start of the next."""
    for i in range(3):
        for q in range(3):
            for m in range(len(w.nu)):
                w.start[i, q, m] = w.ends[i, q, m]
