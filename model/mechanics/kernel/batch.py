"""What Newton solves at once: many problems side by side, and what is left one by one."""

# ruff: noqa: C901  (calls that numba does not inline cost more than they explain)
from __future__ import annotations

from typing import Any

import numpy as np

from model.jit import Array, jit
from model.mechanics.kernel.branch import FAILED, SOLVED
from model.mechanics.kernel.lanes import (
    Lanes,
    at_contact,
    eliminate,
    evaluate,
    matrices,
    new_lanes,
    pass_on,
    polynomials,
    restart,
    right_hand_sides,
    sines,
)
from model.mechanics.kernel.newton import SMALL_STEP, newton
from model.mechanics.kernel.panel import new_work
from model.mechanics.kernel.start import cold

WIDEST, NARROW = 96, 8  # lanes: as many as the second cache holds; in multiples of a register's
# Up to this many take about as long one by one, and what solves them side by side takes a quarter
# of a minute to compile.
FEW = WIDEST
MOST_STEPS = 8  # of all lanes, for the sake of one


@jit
def load(kappa: Array, soft: Array, angles: Array, warm: Array, first: int, w: Lanes) -> bool:
    """Problems from `first` on into the lanes; the last one stands in for those that lack.

    Returns whether one of them has no start.
    """
    cold = False
    for m in range(len(w.nu)):
        k = min(first + m, len(angles) - 1)
        c = min(k, len(soft) - 1)
        cold = cold or not warm[k]
        w.angle[m] = angles[k]
        for p in range(kappa.shape[1]):
            for d in range(kappa.shape[2]):
                w.kappa[p, d, m] = kappa[k, p, d]
            for d in range(soft.shape[2]):
                w.soft[p, d, m] = soft[c, p, d]
    return cold


@jit
def resume(first: int, warm: Array, psi: Array, x: Array, w: Lanes) -> None:
    """Load the given starting values into the lanes."""
    for m in range(len(w.nu)):
        k = min(first + m, len(warm) - 1)
        if warm[k]:
            w.nu[m], w.s_hat[m] = x[k, 0], x[k, 1]
            for p in range(psi.shape[1]):
                for j in range(psi.shape[2]):
                    w.psi[p, j, m] = psi[k, p, j]


@jit
def crossing(breaks: Array, rule: Any, R: float, w: Lanes, s: Array, free: Array) -> None:
    """Where the free shapes meet the arc, s and polar angle, as `start.free_crossing`."""
    W = len(s)
    x, y, phi, root = np.zeros(W), np.zeros(W), np.zeros(W), np.zeros(W)
    step, dx, dy, t, K = np.zeros(W), np.zeros(W), np.zeros(W), np.zeros(W), np.zeros(W)
    low_K, unused, sin, cos = np.zeros(W), np.zeros(W), np.zeros(W), np.zeros(W)
    for m in range(W):
        s[m] = 0.0
    for p in range(len(breaks) - 1):
        low, high = breaks[p], breaks[p + 1]
        half = 0.5 * (high - low)
        for m in range(W):
            t[m] = -1.0
        polynomials(w.kappa[p], t, half, unused, low_K)
        while True:
            longest = 0.0
            for m in range(W):
                gap = R - np.sqrt(x[m] * x[m] + y[m] * y[m])
                goes = low <= s[m] < high and (s[m] < R or gap > 0.02 * R)
                end = min(R if s[m] < R else s[m] + gap, high)  # never beyond the first crossing
                step[m] = end - s[m] if goes else 0.0
                longest = max(longest, step[m])
                dx[m] = dy[m] = 0.0
            if longest == 0.0:
                break
            for j in range(len(rule.c)):
                for m in range(W):
                    t[m] = (s[m] + step[m] * rule.c[j] - low) / half - 1.0
                polynomials(w.kappa[p], t, half, unused, K)
                for m in range(W):
                    K[m] += root[m] - low_K[m]
                sines(K, sin, cos)
                for m in range(W):
                    dx[m] += rule.b[j] * cos[m]
                    dy[m] += rule.b[j] * sin[m]
            for m in range(W):
                x[m] += step[m] * dx[m]
                y[m] += step[m] * dy[m]
                s[m] += step[m]
        for m in range(W):
            t[m] = (s[m] - low) / half - 1.0
        polynomials(w.kappa[p], t, half, unused, K)
        for m in range(W):
            if s[m] >= low:
                phi[m] = root[m] = root[m] + K[m] - low_K[m]
    sines(phi, sin, cos)
    for m in range(W):
        forward = x[m] * cos[m] + y[m] * sin[m]
        missing = R * R - x[m] * x[m] - y[m] * y[m]
        way = missing / (forward + np.sqrt(max(forward * forward + missing, 0.0)) + 1e-300)
        if s[m] < breaks[-1]:
            way = min(way, 0.1 * R)
        s[m] += way
        free[m] = np.arctan2(y[m] + way * sin[m], x[m] + way * cos[m])


@jit
def begin(breaks: Array, rule: Any, R: float, w: Lanes, free: Array) -> None:
    """Compute the free shapes, bent by the force that holds them, as `start.cold`.

    `w.s_hat` and `free` are where they cross the arc.
    """
    W, length = len(w.nu), breaks[-1]
    t, low_K, K, phi, unused = np.zeros(W), np.zeros(W), np.zeros(W), np.zeros(W), np.zeros(W)
    short = R * R * (1.0 - max(0.0, 1.0 - length / R) ** 3)
    for m in range(W):
        w.nu[m] = 3.0 * (free[m] - w.angle[m]) / short
        if length > w.s_hat[m]:
            w.s_hat[m] = R * (1.0 + w.angle[m] * w.angle[m] / 6.0)
    for p in range(len(breaks) - 1):
        low, high = breaks[p], breaks[p + 1]
        half = 0.5 * (high - low)
        for m in range(W):
            t[m] = -1.0
        polynomials(w.kappa[p], t, half, unused, low_K)
        for j in range(len(rule.c) + 1):
            share = 1.0 - rule.c[j] if j < len(rule.c) else 1.0
            for m in range(W):
                h = max(min(w.s_hat[m], high) - low, 0.0)
                t[m] = h * share / half - 1.0
            polynomials(w.kappa[p], t, half, unused, K)
            if j == len(rule.c):
                for m in range(W):
                    phi[m] += K[m] - low_K[m]
                break
            psi = w.psi[p, j]
            for m in range(W):
                top = min(w.s_hat[m], length)
                h = max(min(top, high) - low, 0.0)
                lever, beyond = w.s_hat[m] - low - h * share, w.s_hat[m] - top
                bent = 0.5 * w.nu[m] * (lever * lever - beyond * beyond)
                psi[m] = phi[m] + K[m] - low_K[m] + (bent if h > 0.0 else 0.0)
    for p in range(len(breaks) - 1):
        for j in range(len(rule.c)):
            for m in range(W):
                w.psi[p, j, m] -= phi[m] if w.s_hat[m] > breaks[p] else w.psi[p, j, m]


@jit
def advance(rule: Any, R: float, step: int, w: Lanes, steps: Array, det: Array) -> int:
    """One step of Newton after a sweep; returns how many lanes have not converged.

    steps: at which step a lane converged, 0 before; det: determinant of the closure there.
    """
    P, n, W, e, at = len(w.psi), len(rule.c), len(w.nu), w.ends, w.at
    dnu, ds, largest, scale = np.zeros(W), np.zeros(W), np.zeros(W), np.zeros(W)
    turn, sin, cos = w.rows[0], w.rows[1], w.rows[2]
    for m in range(W):
        turn[m] = w.angle[m] + at[0, m]
    sines(turn, sin, cos)
    for m in range(W):
        Rs, Rc = R * sin[m], R * cos[m]
        n1, n2 = e[1, 0, m] + Rs * e[0, 0, m], e[2, 0, m] - Rc * e[0, 0, m]
        s1, s2 = e[1, 1, m] + Rs * e[0, 1, m], e[2, 1, m] - Rc * e[0, 1, m]
        g1 = at[1, m] - Rc + e[1, 2, m] + Rs * e[0, 2, m]
        g2 = at[2, m] - Rs + e[2, 2, m] - Rc * e[0, 2, m]
        found = n1 * s2 - n2 * s1
        dnu[m] = -(g1 * s2 - g2 * s1) / found
        ds[m] = -(n1 * g2 - n2 * g1) / found
        largest[m] = max(abs(ds[m]) * 4.0 / R, abs(dnu[m]) * R * R / 8.0)
        det[m] = found if steps[m] == 0 else det[m]
    for p in range(P):
        for i in range(n):
            by_nu, by_s, change = w.columns[p, i, 0], w.columns[p, i, 1], w.columns[p, i, 2]
            for m in range(W):
                change[m] += dnu[m] * by_nu[m] + ds[m] * by_s[m]
            for m in range(W):
                largest[m] = max(largest[m], abs(change[m]))
    left = 0
    for m in range(W):
        sane = steps[m] == 0 and largest[m] < 1e6  # not where it is not a number
        scale[m] = 1.0 / max(largest[m], 1.0) if sane else 0.0
        if not sane:
            continue
        if largest[m] < SMALL_STEP:
            steps[m] = step
            w.phi_hat[m] = -(at[0, m] + e[0, 2, m] + dnu[m] * e[0, 0, m] + ds[m] * e[0, 1, m])
        else:
            left += 1
        w.nu[m] += scale[m] * dnu[m]
        w.s_hat[m] = max(w.s_hat[m] + scale[m] * ds[m], 0.98 * R)
    for p in range(P):
        for i in range(n):
            psi, change = w.psi[p, i], w.columns[p, i, 2]
            for m in range(W):
                psi[m] += scale[m] * change[m] if scale[m] > 0.0 else 0.0
    return left


@jit
def store(k: int, m: int, w: Lanes, psi: Array, x: Array) -> None:
    """Store a lane's result in its problem."""
    x[k, 0], x[k, 1], x[k, 2] = w.nu[m], w.s_hat[m], w.phi_hat[m]
    for p in range(psi.shape[1]):
        for j in range(psi.shape[2]):
            psi[k, p, j] = w.psi[p, j, m]


@jit
def side_by_side(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, reach: float, angles: Array,
    warm: Array, psi: Array, x: Array, status: Array,
) -> int:  # fmt: skip
    """SOLVED where the lanes converge to what is surely on the branch; returns how many are not.

    All loops over steps and panels stand here: what calls is compiled again with what it calls.
    """
    left, (K, P, D), n, length = 0, kappa.shape, len(rule.c), breaks[-1]
    W = min(WIDEST, NARROW * ((K + NARROW - 1) // NARROW))
    w = new_lanes(P, n, D, soft.shape[2], W)
    steps, det, free = np.zeros(W, np.int64), np.zeros(W), np.zeros(W)
    alone = reach <= length * (1.0 + 1e-9)  # on the sheet there is never a second equilibrium
    for first in range(0, K, W):
        count = min(W, K - first)
        if load(kappa, soft, angles, warm, first, w):
            crossing(breaks, rule, R, w, w.s_hat, free)
            begin(breaks, rule, R, w, free)
        resume(first, warm, psi, x, w)
        for m in range(W):
            steps[m] = 0
        for step in range(1, MOST_STEPS + 1):
            at_contact(breaks, w)
            for p in range(P - 1, -1, -1):
                restart(w)
                evaluate(breaks, rule, p, w)
                matrices(rule, w)
                right_hand_sides(rule, p, w)
                eliminate(w.J, w.columns[p])
                pass_on(rule, p, w)
            if advance(rule, R, step, w, steps, det) == 0:
                break
        for m in range(count):
            k = first + m
            sure = steps[m] > 0 and w.s_hat[m] <= reach
            if warm[k] or not (alone and w.s_hat[m] <= length):
                sure = sure and det[m] > 0.0 and (warm[k] or abs(free[m] - angles[k]) < 1.0)
            status[k] = SOLVED if sure else FAILED
            if sure:
                store(k, m, w, psi, x)
            else:
                left += 1
    return left


@jit
def one_by_one(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: Array, reach: float, angles: Array,
    warm: Array, psi: Array, x: Array, status: Array, every: bool,
) -> int:  # fmt: skip
    """Solve the problems one by one, all or only the FAILED; return how many failed."""
    w, left = new_work(len(rule.c), 3), 0
    columns = np.zeros((len(breaks) - 1, len(rule.c), 3))
    for k in range(len(angles)):
        if not every and status[k] != FAILED:
            continue
        c, radius = soft[min(k, len(soft) - 1)], R[min(k, len(R) - 1)]
        steps, determinant = 0, 0.0
        if warm[k]:
            steps, determinant = newton(
                breaks=breaks,
                kappa=kappa[k],
                soft=c,
                rule=rule,
                R=radius,
                angle=angles[k],
                psi=psi[k],
                x=x[k],
                columns=columns,
                w=w,
            )
        if steps == 0 or determinant <= 0.0 or x[k, 1] > reach:
            steps = cold(
                breaks=breaks,
                kappa=kappa[k],
                soft=c,
                rule=rule,
                R=radius,
                reach=reach,
                angle=angles[k],
                psi=psi[k],
                x=x[k],
                columns=columns,
                w=w,
            )
        status[k] = SOLVED if steps > 0 and x[k, 1] <= reach else FAILED
        left += 1 if status[k] == FAILED else 0
    return left


def solve_many(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: Array, reach: float, angles: Array,
    warm: Array, psi: Array, x: Array, status: Array,
) -> int:  # fmt: skip
    """Solve kappa (K, P, D), angles (K,) into psi (K, P, n), x (K, 3), the start where `warm`.

    R (1,) is the radius of all, or (K,) of each: the lanes have one alone. Returns how many are
    left FAILED, for `rescue_many`.
    """
    few = len(angles) <= FEW or len(R) > 1
    if not few and not side_by_side(
        breaks=breaks,
        kappa=kappa,
        soft=soft,
        rule=rule,
        R=float(R[0]),
        reach=reach,
        angles=angles,
        warm=warm,
        psi=psi,
        x=x,
        status=status,
    ):
        return 0
    return one_by_one(
        breaks=breaks,
        kappa=kappa,
        soft=soft,
        rule=rule,
        R=R,
        reach=reach,
        angles=angles,
        warm=warm,
        psi=psi,
        x=x,
        status=status,
        every=few,
    )
