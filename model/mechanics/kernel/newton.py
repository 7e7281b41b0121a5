"""Newton's method for one problem: a linearisation panel after panel, and two closing equations."""

# ruff: noqa: C901  (calls that numba does not inline cost more than they explain)
from __future__ import annotations

from typing import Any

import numpy as np

from model.jit import Array, jit
from model.mechanics.kernel.panel import (
    Work,
    evaluate,
    matrix,
    moving_top,
    panel_of,
    parameter_columns,
    pass_on,
    restart,
    solve_in_place,
)

MOST_STEPS = 25
SMALL_STEP = 2e-6


@jit
def sweep(
    breaks: Array, kappa: Array, soft: Array, rule: Any, psi: Array, nu: float, s_hat: float,
    dkappa: Array, dsoft: Array, dlength: Array, columns: Array, w: Work,
) -> tuple[float, float, float]:  # fmt: skip
    """Linearise panel after panel, from the contact to the clamp.

    psi (P, n) is the present iterate; columns (P, n, C) receives how it answers: to nu, s_hat, and
    the parameters dkappa, dsoft, dlength, or without these to Newton's residual. Returns psi, a
    and b at the clamp; how they answer is left in `w.ends`.
    """
    n, length, newton = len(rule.c), breaks[-1], len(dlength) == 0
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
        k_top, turn = evaluate(
            rule=rule,
            kappa=kappa[p],
            soft=soft[p],
            psi=psi[p],
            t_top=t_top,
            half=half,
            h=h,
            a_top=a_s,
            w=w,
        )
        matrix(rule, soft.shape[1] == 0, nu * h * h, w)
        restart(w)
        for i in range(n):
            for q in range(w.rhs.shape[1]):
                w.rhs[i, q] = w.start[0, q] + nu * h * w.Ac[i] * w.start[1, q]
            w.rhs[i, 0] += h * w.T[i]
            if newton:
                w.rhs[i, 2] -= psi[p, i] - psi_s + w.K[i] - nu * h * w.T[i]
        if not newton:
            parameter_columns(
                rule=rule,
                nu=nu,
                h=h,
                t_top=t_top,
                half=half,
                dkappa=dkappa[:, p],
                dsoft=dsoft[:, p],
                w=w,
            )
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


@jit
def closure(
    R: float, angle: float, ends: tuple[float, float, float], w: Work, column: int
) -> tuple[float, float]:
    """How the two closure equations answer to a column."""
    turn = R * w.ends[0, column]
    return (
        w.ends[1, column] + np.sin(angle + ends[0]) * turn,
        w.ends[2, column] - np.cos(angle + ends[0]) * turn,
    )


@jit
def newton(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, angle: float,
    psi: Array, x: Array, columns: Array, w: Work,
) -> tuple[int, float]:  # fmt: skip
    """Improve psi (P, n) and x = (nu, s_hat, phi_hat) in place.

    Returns the steps it took, 0 when it did not converge, and the determinant of the closure.
    """
    length, none = breaks[-1], np.zeros((0, 0, 1))
    nothing = np.zeros(0)
    for step in range(1, MOST_STEPS + 1):
        ends = sweep(
            breaks=breaks,
            kappa=kappa,
            soft=soft,
            rule=rule,
            psi=psi,
            nu=x[0],
            s_hat=x[1],
            dkappa=none,
            dsoft=none,
            dlength=nothing,
            columns=columns,
            w=w,
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
            return step, determinant
    return 0, 0.0
