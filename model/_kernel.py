"""Compiled equilibrium: see `beam.py` for the problem and its notation, `_twin.py` for NumPy's way.

Gauss-Legendre collocation in the contact frame: psi = phi - phi_hat, integrated backward from the
contact, panel by panel, with a = (p_hat - r).t_hat and nu = N/B:
    psi' = -(k* - nu c a),   k* = k0 + Me/B(s),   c = B/B(s),   a' = cos psi.
The unknowns are psi at all nodes, nu and s_hat. The nodes of a panel are eliminated by a dense
solve; what goes on to the next panel is how psi, a and b = (p_hat - r).n_hat answer to the columns
(nu, s_hat, and then the Newton residual or each parameter asked for), so that the closure
r(s_hat) = p_hat remains: two equations with two unknowns.

Longer than other files for a reason: numba's cache on disk notices changes of this file only, so
everything compiled stands here. `beam.py` imports it when an equilibrium is first asked for, for
importing numba takes the best part of a second.
A panel runs backward from `top` to `bottom` = top - h, theta = 0 .. 1, nodes s_j = top - h c_j.
"""

# ruff: noqa: C901, FBT003  (calls that numba does not inline cost more than they explain)
from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast

import numba
import numpy as np

Array = np.ndarray[Any, Any]
_Function = TypeVar("_Function", bound=Callable[..., Any])

SOLVED, SLIPPED, FAILED = 0, 1, 2
MOST_STEPS = 25
SMALL_STEP = 2e-6


def _drop_stale() -> None:
    """Remove what an older version of this file left on disk: numba may stumble over its types."""
    source = Path(__file__)
    with contextlib.suppress(OSError):
        written = source.stat().st_mtime
        for old in (source.parent / "__pycache__").glob("_kernel.*.nb[ic]"):
            if old.stat().st_mtime < written:
                old.unlink()


_drop_stale()


def compiled(function: _Function) -> _Function:
    """numba.njit, kept on disk: compiled once a machine, free of the interpreter's lock."""
    make = numba.njit(
        cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz", "arcp"}
    )
    return cast("_Function", make(function))


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


@compiled
def new_work(n: int, columns: int) -> Work:
    """Scratch arrays for n nodes."""
    return Work(
        np.zeros((3, columns)), np.zeros((3, columns)), np.zeros((n, n)), np.zeros((n, columns)),
        np.zeros(n), np.zeros(n), np.zeros(n), np.ones(n), np.zeros(n), np.zeros(n), np.zeros(n),
        np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n),
    )  # fmt: skip


@compiled
def polynomial(row: Array, t: float, half: float) -> tuple[float, float, float]:
    """Value, integral over s from t = 0, and slope d/ds of a panel's polynomial at t."""
    value, integral, slope = 0.0, 0.0, 0.0
    for d in range(len(row) - 1, -1, -1):
        slope = slope * t + value
        value = value * t + row[d]
        integral = integral * t + row[d] / (d + 1)
    return value, integral * t * half, slope / half


@compiled
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


@compiled
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


@compiled
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


@compiled
def parameter_columns(
    rule: Any, nu: float, h: float, t_top: float, half: float, dkappa: Array, dsoft: Array, w: Work
) -> None:
    """Add to the right-hand sides what a change of k*(s) and c(s) does; (Q, D) rows of this panel.

    What they do to psi at the panel's end goes to `w.ends[0]`.
    """
    n = len(rule.c)
    for q in range(len(dkappa)):
        _, K_top, _ = polynomial(dkappa[q], t_top, half)
        _, K_bottom, _ = polynomial(dkappa[q], t_top - h / half, half)
        w.ends[0, 2 + q] = K_bottom - K_top
        for i in range(n):
            _, K, _ = polynomial(dkappa[q], t_top - h * rule.c[i] / half, half)
            w.rhs[i, 2 + q] += K - K_top
        if dsoft.shape[1] > 0:
            for j in range(n):
                dc, _, _ = polynomial(dsoft[q], t_top - h * rule.c[j] / half, half)
                w.ends[0, 2 + q] += nu * h * rule.b[j] * dc * w.a[j]
                for i in range(n):
                    w.rhs[i, 2 + q] += nu * h * rule.A[i, j] * dc * w.a[j]


@compiled
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


@compiled
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


@compiled
def panel_of(breaks: Array, s: float) -> int:
    """The panel that begins before s and does not end before it."""
    m = len(breaks) - 2
    while m > 0 and breaks[m] >= s:
        m -= 1
    return m


@compiled
def keep(psi: Array, x: Array, to_psi: Array, to_x: Array) -> None:
    """Copy a state; loops, for slices cost seconds of compiling."""
    for i in range(len(x)):
        to_x[i] = x[i]
    for p in range(psi.shape[0]):
        for j in range(psi.shape[1]):
            to_psi[p, j] = psi[p, j]


@compiled
def restart(w: Work) -> None:
    """The answers at the end of one panel are those at the start of the next."""
    for j in range(w.ends.shape[1]):
        for i in range(3):
            w.start[i, j] = w.ends[i, j]
            w.ends[i, j] = 0.0


@compiled
def sweep(
    breaks: Array, kappa: Array, soft: Array, rule: Any, psi: Array, nu: float, s_hat: float,
    dkappa: Array, dsoft: Array, dlength: Array, newton: bool, columns: Array, w: Work,
) -> tuple[float, float, float]:  # fmt: skip
    """Linearise panel after panel, from the contact to the clamp.

    psi (P, n) is the present iterate; columns (P, n, C) receives how it answers. Returns psi, a and
    b at the clamp; how they answer is left in `w.ends`.
    """
    n, length = len(rule.c), breaks[-1]
    on_sheet = s_hat < length
    top = min(s_hat, length)
    psi_s, a_s, b_s = 0.0, s_hat - top, 0.0
    for q in range(w.ends.shape[1]):
        w.ends[0, q] = w.ends[1, q] = w.ends[2, q] = 0.0
        if q >= 2 and not newton and not on_sheet:
            w.ends[1, q] = -dlength[q - 2]
    w.ends[1, 1] = 0.0 if on_sheet else 1.0
    contact = panel_of(breaks, top)
    for p in range(contact, -1, -1):
        h = top - breaks[p]
        half = 0.5 * (breaks[p + 1] - breaks[p])
        t_top = (top - breaks[p]) / half - 1.0
        k_top, turn = evaluate(rule, kappa[p], soft[p], psi[p], t_top, half, h, a_s, w)
        matrix(rule, soft.shape[1] == 0, nu * h * h, w)
        restart(w)
        for i in range(n):
            for q in range(w.rhs.shape[1]):
                w.rhs[i, q] = w.start[0, q] + nu * h * w.Ac[i] * w.start[1, q]
            w.rhs[i, 0] += h * w.T[i]
            if newton:
                w.rhs[i, 2] -= psi[p, i] - psi_s + w.K[i] - nu * h * w.T[i]
        if not newton:
            parameter_columns(rule, nu, h, t_top, half, dkappa[:, p], dsoft[:, p], w)
        if p == contact:
            end = moving_top(rule, nu, h, a_s, k_top, w)
            run, rise = 0.0, 0.0
            for i in range(n):
                run += rule.b[i] * w.cos[i]
                rise += rule.b[i] * w.sin[i]
            for q in range(1, w.rhs.shape[1]):
                rate = 0.0
                if q == 1:
                    rate = 1.0 if on_sheet else 0.0
                elif not newton and not on_sheet:
                    rate = dlength[q - 2]
                if rate != 0.0:
                    for i in range(n):
                        w.rhs[i, q] -= rate * w.move[i]
                    w.ends[0, q] += rate * end
                    w.ends[1, q] += rate * run
                    w.ends[2, q] += rate * rise
        solve_in_place(w.J, w.rhs)
        for i in range(n):
            for q in range(w.rhs.shape[1]):
                columns[p, i, q] = w.rhs[i, q]
        moment, run, rise = pass_on(rule, nu, h, w)
        psi_s += nu * h * moment - turn
        a_s += h * run
        b_s += h * rise
        top = breaks[p]
    return psi_s, a_s, b_s


@compiled
def closure(
    R: float, angle: float, ends: tuple[float, float, float], w: Work, column: int
) -> tuple[float, float]:
    """How the two closure equations answer to a column."""
    turn = R * w.ends[0, column]
    return (
        w.ends[1, column] + np.sin(angle + ends[0]) * turn,
        w.ends[2, column] - np.cos(angle + ends[0]) * turn,
    )


@compiled
def newton(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, angle: float,
    psi: Array, x: Array, columns: Array, w: Work,
) -> tuple[int, float]:  # fmt: skip
    """Improve psi (P, n) and x = (nu, s_hat, phi_hat, polar angle of the contact) in place.

    Returns the steps it took, 0 when it did not converge, and the determinant of the closure.
    """
    length, none = breaks[-1], np.zeros((0, 0, 1))
    nothing = np.zeros(0)
    for step in range(1, MOST_STEPS + 1):
        ends = sweep(
            breaks, kappa, soft, rule, psi, x[0], x[1], none, none, nothing, True, columns, w
        )
        r1 = ends[1] - R * np.cos(angle + ends[0])
        r2 = ends[2] - R * np.sin(angle + ends[0])
        n1, n2 = closure(R, angle, ends, w, 0)
        s1, s2 = closure(R, angle, ends, w, 1)
        g1, g2 = closure(R, angle, ends, w, 2)
        determinant = n1 * s2 - n2 * s1
        dnu = -((r1 + g1) * s2 - (r2 + g2) * s1) / determinant
        ds = -(n1 * (r2 + g2) - n2 * (r1 + g1)) / determinant
        if not (np.isfinite(dnu) and np.isfinite(ds)):
            return 0, 0.0
        largest = max(abs(ds) / (0.25 * R), abs(dnu) * R * R / 8.0)
        contact = panel_of(breaks, min(x[1], length))
        for p in range(contact + 1):
            for i in range(len(rule.c)):
                d = columns[p, i, 2] + dnu * columns[p, i, 0] + ds * columns[p, i, 1]
                columns[p, i, 2] = d
                largest = max(largest, abs(d))
        scale = 1.0 if largest < 1.0 else 1.0 / largest
        for p in range(contact + 1):
            for i in range(len(rule.c)):
                psi[p, i] += scale * columns[p, i, 2]
        for p in range(contact + 1, len(psi)):
            for i in range(len(rule.c)):
                psi[p, i] = 0.0
        x[0] += scale * dnu
        x[1] = max(x[1] + scale * ds, 0.98 * R)
        if largest < SMALL_STEP:
            # convergence is quadratic: what is left is the square of the step
            x[2] = -(ends[0] + w.ends[0, 2] + dnu * w.ends[0, 0] + ds * w.ends[0, 1])
            a = ends[1] + w.ends[1, 2] + dnu * w.ends[1, 0] + ds * w.ends[1, 1]
            b = ends[2] + w.ends[2, 2] + dnu * w.ends[2, 0] + ds * w.ends[2, 1]
            x[3] = np.arctan2(b, a) + x[2]
            return step, determinant
    return 0, 0.0


@compiled
def free_angle(breaks: Array, kappa: Array, p: int, s: float, phi: float) -> float:
    """Phi of the free shape at s in panel p, phi being that at the panel's beginning."""
    half = 0.5 * (breaks[p + 1] - breaks[p])
    _, low, _ = polynomial(kappa[p], -1.0, half)
    _, high, _ = polynomial(kappa[p], (s - breaks[p]) / half - 1.0, half)
    return phi + high - low


@compiled
def free_step(
    breaks: Array, kappa: Array, rule: Any, p: int, phi: float, s: float, end: float
) -> tuple[float, float]:
    """The way of the free shape from s to end, both in panel p."""
    x, y = 0.0, 0.0
    for j in range(len(rule.c)):
        angle = free_angle(breaks, kappa, p, s + (end - s) * rule.c[j], phi)
        x += rule.b[j] * np.cos(angle)
        y += rule.b[j] * np.sin(angle)
    return x * (end - s), y * (end - s)


@compiled
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


@compiled
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


@compiled
def bent_start(breaks: Array, rule: Any, x: Array, psi: Array) -> None:
    """Bend the free shape by the force's moment with the lever of a straight sheet."""
    top = min(x[1], breaks[-1])
    for p in range(panel_of(breaks, top) + 1):
        h = min(top, breaks[p + 1]) - breaks[p]
        for j in range(len(rule.c)):
            lever = x[1] - breaks[p] - h * (1.0 - rule.c[j])
            psi[p, j] += 0.5 * x[0] * (lever * lever - (x[1] - top) ** 2)


@compiled
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
    steps, determinant = newton(breaks, kappa, soft, rule, R, angle, psi, x, columns, w)
    if x[1] <= length and reach <= length * (
        1.0 + 1e-9
    ):  # on the sheet there is never a second one
        return steps
    return steps if determinant > 0.0 and steps < 9 and abs(free - angle) < 1.0 else 0


@compiled
def solve_many(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, reach: float, angles: Array,
    warm: Array, psi: Array, x: Array, status: Array,
) -> None:  # fmt: skip
    """Every problem of a batch that Newton solves at once: kappa (K, P, D), angles (K,).

    psi (K, P, n) and x (K, 4) are the results, and the start where `warm`. What is left FAILED is
    for `rescue_many`.
    """
    w = new_work(len(rule.c), 3)
    columns = np.zeros((len(breaks) - 1, len(rule.c), 3))
    for k in range(len(angles)):
        c, steps, determinant = soft[min(k, len(soft) - 1)], 0, 0.0
        if warm[k]:
            steps, determinant = newton(
                breaks, kappa[k], c, rule, R, angles[k], psi[k], x[k], columns, w
            )
        if steps == 0 or determinant <= 0.0 or x[k, 1] > reach:
            steps = cold(breaks, kappa[k], c, rule, R, reach, angles[k], psi[k], x[k], columns, w)
        status[k] = SOLVED if steps > 0 and x[k, 1] <= reach else FAILED


@compiled
def march(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, start: float, angle: float,
    psi: Array, x: Array, columns: Array, w: Work,
) -> tuple[int, float]:  # fmt: skip
    """Follow the branch from the equilibrium at `start` to `angle`, as fast as Newton likes."""
    kept, kept_x, before = np.empty_like(psi), np.empty_like(x), np.empty_like(x)
    keep(psi, x, kept, kept_x)
    at, last, step, determinant = start, 0.0, 0.1, 0.0
    while at != angle:
        step = min(step, 0.3)
        aim = angle if abs(angle - at) <= step else at + np.copysign(step, angle - at)
        if last > 0.0:  # secant predictor
            for i in range(2):
                x[i] += (kept_x[i] - before[i]) * abs(aim - at) / last
            x[1] = max(x[1], 0.98 * R)
        steps, found = newton(
            breaks, kappa, soft, rule, R, aim, psi, x, columns, w
        )  # fmt: skip
        turned = determinant != 0.0 and found * determinant <= 0.0
        if steps == 0 or turned or abs(x[1] - kept_x[1]) > 0.1 * R:
            keep(kept, kept_x, psi, x)
            step *= 0.4
            if step < 1e-4:
                return 0, 0.0
        else:
            for i in range(2):
                before[i] = kept_x[i]
            last = abs(aim - at)
            keep(psi, x, kept, kept_x)
            at, determinant = aim, found
            step *= 2.0 if steps <= 5 else 1.0
    return 1, determinant


@compiled
def from_free(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, angle: float,
    psi: Array, x: Array, columns: Array, w: Work,
) -> int:  # fmt: skip
    """Follow the branch from the free shape to the position."""
    s_free, free = free_crossing(breaks, kappa, rule, R)
    x[0], x[1] = 0.0, s_free
    free_start(breaks, kappa, rule, s_free, psi)
    steps, _ = newton(breaks, kappa, soft, rule, R, free, psi, x, columns, w)
    if steps == 0:
        return 0
    return march(breaks, kappa, soft, rule, R, free, angle, psi, x, columns, w)[0]


@compiled
def from_straight(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, angle: float,
    psi: Array, x: Array, columns: Array, w: Work,
) -> int:  # fmt: skip
    """Bring a straight sheet to the position, then let its free curvature grow."""
    scaled, kept, kept_x = np.zeros_like(kappa), np.zeros_like(psi), np.zeros_like(x)
    keep(kept, kept_x, psi, x)
    x[1] = R * 1.0001
    if march(breaks, scaled, soft, rule, R, 0.0, angle, psi, x, columns, w)[0] == 0:
        return 0
    keep(psi, x, kept, kept_x)
    at, step = 0.0, 0.25
    while at < 1.0:
        aim = min(at + step, 1.0)
        for p in range(kappa.shape[0]):
            for d in range(kappa.shape[1]):
                scaled[p, d] = aim * kappa[p, d]
        steps, _ = newton(breaks, scaled, soft, rule, R, angle, psi, x, columns, w)
        if steps == 0 or abs(x[1] - kept_x[1]) > 0.1 * R:
            keep(kept, kept_x, psi, x)
            step *= 0.4
            if step < 1e-3:
                return 0
        else:
            keep(psi, x, kept, kept_x)
            at = aim
            step *= 1.6 if steps <= 6 else 1.0
    return 1


@compiled
def rescue_many(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, reach: float, angles: Array,
    psi: Array, x: Array, status: Array,
) -> None:  # fmt: skip
    """Every problem that is still FAILED, step by step along its branch."""
    w = new_work(len(rule.c), 3)
    columns = np.zeros((len(breaks) - 1, len(rule.c), 3))
    for k in range(len(angles)):
        if status[k] != FAILED:
            continue
        c, ways = soft[min(k, len(soft) - 1)], 0
        # curled away from the arc when free, a sheet may yet be held by the rolls: second way
        for way in range(2):
            if way == 0:
                found = from_free(breaks, kappa[k], c, rule, R, angles[k], psi[k], x[k], columns, w)
            else:
                found = from_straight(
                    breaks, kappa[k], c, rule, R, angles[k], psi[k], x[k], columns, w
                )
            ways += found
            if found > 0 and x[k, 1] <= reach:
                status[k] = SOLVED
                break
        if status[k] == FAILED and ways > 0:
            status[k] = SLIPPED


@compiled
def legendre_weights(rule: Any, theta: float, out: Array, low: Array) -> None:
    """Weights on nodal values for the integral from 0 to theta (a share of the panel)."""
    n = len(rule.c)
    t = 2.0 * theta - 1.0
    before, now = 1.0, t
    low[0] = t + 1.0
    for k in range(1, n):
        after = ((2 * k + 1) * t * now - k * before) / (k + 1)
        low[k] = (after - before) / (2 * k + 1)
        before, now = now, after
    for j in range(n):
        total = 0.0
        for k in range(n):
            total += low[k] * rule.T[k, j]
        out[j] = 0.5 * total


class Strip(NamedTuple):
    """The sheet from the clamp on in ascending panels: one more where the contact cuts one."""

    edges: Array  # (P + 2,)
    of: Array  # (P + 1,) the panel of the problem each lies in
    phi: Array  # (P + 1, n) at ascending nodes
    cos: Array  # of phi
    sin: Array
    a: Array  # (P + 1, n) lever of the contact force; 0 in the tail
    push: Array  # (P + 1, n) c a
    x: Array  # (P + 2,) at the edges
    y: Array
    phi_edge: Array


@compiled
def new_strip(P: int, n: int) -> Strip:
    """Room for a sheet of P panels."""
    return Strip(
        np.zeros(P + 2), np.zeros(P + 1, dtype=np.int64), np.zeros((P + 1, n)),
        np.zeros((P + 1, n)), np.zeros((P + 1, n)), np.zeros((P + 1, n)), np.zeros((P + 1, n)),
        np.zeros(P + 2), np.zeros(P + 2), np.zeros(P + 2),
    )  # fmt: skip


@compiled
def cut(breaks: Array, top: float, strip: Strip) -> int:
    """Panels between the breaks and the contact; returns how many."""
    count = 0
    for p in range(len(breaks) - 1):
        strip.edges[count], strip.of[count] = breaks[p], p
        count += 1
        if breaks[p] < top < breaks[p + 1]:
            strip.edges[count], strip.of[count] = top, p
            count += 1
    strip.edges[count] = breaks[-1]
    return count


@compiled
def unroll(
    breaks: Array, kappa: Array, soft: Array, rule: Any, psi: Array, nu: float, top: float,
    phi_hat: float, a_clamp: float, strip: Strip,
) -> int:  # fmt: skip
    """Fill the strip from the clamp on; returns its number of panels."""
    n, count = len(rule.c), cut(breaks, top, strip)
    a_edge, cos_hat, sin_hat = a_clamp, np.cos(phi_hat), np.sin(phi_hat)
    strip.x[0] = strip.y[0] = strip.phi_edge[0] = 0.0
    for m in range(count):
        p, low, high = strip.of[m], strip.edges[m], strip.edges[m + 1]
        half, h, loaded = 0.5 * (breaks[p + 1] - breaks[p]), high - low, high <= top
        t_low, t_high = (low - breaks[p]) / half - 1.0, (high - breaks[p]) / half - 1.0
        _, K_low, _ = polynomial(kappa[p], t_low, half)
        _, K_high, _ = polynomial(kappa[p], t_high, half)
        run, rise, press = 0.0, 0.0, 0.0
        for j in range(n):
            if loaded:
                strip.phi[m, j] = phi_hat + psi[p, n - 1 - j]
            else:
                _, K, _ = polynomial(kappa[p], t_low + h * rule.c[j] / half, half)
                strip.phi[m, j] = strip.phi_edge[m] + K - K_low
            strip.cos[m, j], strip.sin[m, j] = np.cos(strip.phi[m, j]), np.sin(strip.phi[m, j])
            run += rule.b[j] * strip.cos[m, j]
            rise += rule.b[j] * strip.sin[m, j]
        for j in range(n):
            strip.a[m, j] = strip.push[m, j] = 0.0
            if loaded:
                a, c = a_edge, 1.0
                for k in range(n):
                    a -= h * rule.A[j, k] * (strip.cos[m, k] * cos_hat + strip.sin[m, k] * sin_hat)
                if soft.shape[1] > 0:
                    c, _, _ = polynomial(soft[p], t_low + h * rule.c[j] / half, half)
                strip.a[m, j], strip.push[m, j] = a, c * a
                press += rule.b[j] * c * a
        strip.x[m + 1] = strip.x[m] + h * run
        strip.y[m + 1] = strip.y[m] + h * rise
        strip.phi_edge[m + 1] = strip.phi_edge[m] + K_high - K_low - nu * h * press
        a_edge -= h * (run * cos_hat + rise * sin_hat)
    return count


@compiled
def lever_integral(rule: Any, strip: Strip, count: int) -> float:
    """Integral of a over the loaded part."""
    total = 0.0
    for m in range(count):
        for j in range(len(rule.c)):
            total += (strip.edges[m + 1] - strip.edges[m]) * rule.b[j] * strip.a[m, j]
    return total


@compiled
def points(
    breaks: Array, kappa: Array, soft: Array, rule: Any, nu: float, top: float, phi_hat: float,
    x_hat: float, y_hat: float, strip: Strip, count: int, s: Array, dphi: Array, dphi_hat: Array,
    out: Array, dout: Array, weights: Array,
) -> None:  # fmt: skip
    """x, y, phi, k at each s into out (S, 4), answers of x, y into dout (Q, S, 2).

    dphi (P + 1, Q, n) is how phi at the strip's nodes answers, at fixed s; weights (3, n) is
    scratch.
    """
    n, Q, length = len(rule.c), dphi.shape[1], breaks[-1]
    cos_hat, sin_hat = np.cos(phi_hat), np.sin(phi_hat)
    dr = np.zeros((count + 1, Q, 2))
    for m in range(count):
        h = strip.edges[m + 1] - strip.edges[m]
        for q in range(Q):
            dx, dy = 0.0, 0.0
            for j in range(n):
                turn = h * rule.b[j] * dphi[m, q, j]
                dx -= turn * strip.sin[m, j]
                dy += turn * strip.cos[m, j]
            dr[m + 1, q, 0], dr[m + 1, q, 1] = dr[m, q, 0] + dx, dr[m, q, 1] + dy
    for i in range(len(s)):
        if s[i] > length:
            beyond, phi = s[i] - length, strip.phi_edge[count]
            out[i, 0] = strip.x[count] + beyond * np.cos(phi)
            out[i, 1] = strip.y[count] + beyond * np.sin(phi)
            out[i, 2], out[i, 3] = phi, 0.0
            for q in range(Q):
                dout[q, i, 0] = dr[count, q, 0] - beyond * np.sin(phi) * dphi_hat[q]
                dout[q, i, 1] = dr[count, q, 1] + beyond * np.cos(phi) * dphi_hat[q]
            continue
        m = count - 1
        while m > 0 and strip.edges[m] > s[i]:
            m -= 1
        p, low, h = strip.of[m], strip.edges[m], strip.edges[m + 1] - strip.edges[m]
        half = 0.5 * (breaks[p + 1] - breaks[p])
        t_low, t = (low - breaks[p]) / half - 1.0, (s[i] - breaks[p]) / half - 1.0
        legendre_weights(rule, (s[i] - low) / h, weights[0], weights[1])
        x, y, press = strip.x[m], strip.y[m], 0.0
        for j in range(n):
            weight = h * weights[0, j]
            weights[1, j], weights[2, j] = weight * strip.cos[m, j], weight * strip.sin[m, j]
            x += weights[1, j]
            y += weights[2, j]
            press += weight * strip.push[m, j]
        _, K_low, _ = polynomial(kappa[p], t_low, half)
        k, K, _ = polynomial(kappa[p], t, half)
        if s[i] <= top:
            lever = (x_hat - x) * cos_hat + (y_hat - y) * sin_hat
            if soft.shape[1] > 0:
                c, _, _ = polynomial(soft[p], t, half)
                lever *= c
            k -= nu * lever
        out[i, 0], out[i, 1] = x, y
        out[i, 2], out[i, 3] = strip.phi_edge[m] + K - K_low - nu * press, k
        for q in range(Q):
            dx, dy = dr[m, q, 0], dr[m, q, 1]
            for j in range(n):
                dx -= weights[2, j] * dphi[m, q, j]
                dy += weights[1, j] * dphi[m, q, j]
            dout[q, i, 0], dout[q, i, 1] = dx, dy


class Moves(NamedTuple):
    """Parameters to differentiate by, Q of them."""

    kappa: Array  # (Q, P, D) change of k*(s)
    soft: Array  # (Q, P, Dc) change of c(s)
    angle: Array  # (Q,) change of the contact's polar angle
    radius: Array  # (Q,) of R
    length: Array  # (Q,) of l


@compiled
def answers(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, angle: float, psi: Array,
    x: Array, to: Moves, columns: Array, w: Work, dx: Array,
) -> None:  # fmt: skip
    """How nu, s_hat, phi_hat answer to the parameters: dx (Q, 3); `columns` as by sweep."""
    ends = sweep(
        breaks, kappa, soft, rule, psi, x[0], x[1], to.kappa, to.soft, to.length, False, columns, w
    )
    n1, n2 = closure(R, angle, ends, w, 0)
    s1, s2 = closure(R, angle, ends, w, 1)
    determinant = n1 * s2 - n2 * s1
    cos, sin = np.cos(angle + ends[0]), np.sin(angle + ends[0])
    for q in range(len(dx)):
        r1, r2 = closure(R, angle, ends, w, 2 + q)
        r1 += R * sin * to.angle[q] - cos * to.radius[q]
        r2 -= R * cos * to.angle[q] + sin * to.radius[q]
        dx[q, 0] = -(r1 * s2 - r2 * s1) / determinant
        dx[q, 1] = -(n1 * r2 - n2 * r1) / determinant
        dx[q, 2] = -(w.ends[0, 2 + q] + w.ends[0, 0] * dx[q, 0] + w.ends[0, 1] * dx[q, 1])


@compiled
def turning(
    breaks: Array, kappa: Array, rule: Any, x: Array, to: Moves, columns: Array, dx: Array,
    strip: Strip, count: int, dphi: Array,
) -> None:  # fmt: skip
    """How phi at the strip's nodes answers to the parameters, at fixed s: dphi (P + 1, Q, n)."""
    n, length = len(rule.c), breaks[-1]
    on_sheet = x[1] < length
    top = min(x[1], length)
    contact = panel_of(breaks, top)
    half = 0.5 * (breaks[contact + 1] - breaks[contact])
    k_top, _, _ = polynomial(kappa[contact], (top - breaks[contact]) / half - 1.0, half)
    for q in range(len(dx)):
        rate = dx[q, 1] if on_sheet else to.length[q]
        tail = dx[q, 2] - k_top * rate
        for m in range(count):
            p, low, high = strip.of[m], strip.edges[m], strip.edges[m + 1]
            half, h = 0.5 * (breaks[p + 1] - breaks[p]), high - low
            t_low = (low - breaks[p]) / half - 1.0
            _, K_low, _ = polynomial(to.kappa[q, p], t_low, half)
            for j in range(n):
                t, i = t_low + h * rule.c[j] / half, n - 1 - j
                if high > top:
                    _, K, _ = polynomial(to.kappa[q, p], t, half)
                    dphi[m, q, j] = tail + K - K_low
                    continue
                change = columns[p, i, 2 + q]
                change += columns[p, i, 0] * dx[q, 0] + columns[p, i, 1] * dx[q, 1]
                if p == contact:  # its nodes move with the contact
                    k, _, _ = polynomial(kappa[p], t, half)
                    change -= (k - x[0] * strip.push[m, j]) * rule.c[j] * rate
                dphi[m, q, j] = dx[q, 2] + change
            if high > top:
                _, K, _ = polynomial(to.kappa[q, p], t_low + h / half, half)
                tail += K - K_low


@compiled
def describe_many(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, angles: Array, psi: Array,
    x: Array, good: Array, s: Array, to: Any, out: Array, lever: Array, dx: Array, dout: Array,
) -> None:  # fmt: skip
    """Shapes of solved problems at s (K, S), and the answers of all to Q parameters.

    `to` holds `Moves` whose arrays lead with K (or with 1: the same for all). Filled are
    out (K, S, 4) = x, y, phi, k; lever (K,) the integral of a; dx (K, Q, 3); dout (K, Q, S, 2).
    """
    n, P, Q = len(rule.c), len(breaks) - 1, dx.shape[1]
    w = new_work(n, 2 + Q)
    columns = np.zeros((P, n, 2 + Q))
    strip, weights, dphi = new_strip(P, n), np.zeros((3, n)), np.zeros((P + 1, Q, n))
    for k in range(len(x)):
        if not good[k]:
            continue
        c = soft[min(k, len(soft) - 1)]
        nu, top = x[k, 0], min(x[k, 1], breaks[-1])
        a_clamp = R * np.cos(angles[k] - x[k, 2])
        count = unroll(breaks, kappa[k], c, rule, psi[k], nu, top, x[k, 2], a_clamp, strip)
        lever[k] = lever_integral(rule, strip, count)
        if Q > 0:
            g = min(k, len(to.kappa) - 1)
            here = Moves(to.kappa[g], to.softness[g], to.angle[g], to.radius[g], to.length[g])
            answers(breaks, kappa[k], c, rule, R, angles[k], psi[k], x[k], here, columns, w, dx[k])
            turning(breaks, kappa[k], rule, x[k], here, columns, dx[k], strip, count, dphi)
        points(
            breaks, kappa[k], c, rule, nu, top, x[k, 2], R * np.cos(angles[k]),
            R * np.sin(angles[k]), strip, count, s[min(k, len(s) - 1)], dphi, dx[k, :, 2],
            out[k], dout[k], weights,
        )  # fmt: skip
