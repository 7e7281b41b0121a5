"""The sheet where the rolls touch it: s_hat, its angle and place, and how these follow from q."""

from __future__ import annotations

from typing import Any

import numpy as np

from model.dynamics.kernel.work import Scratch
from model.jit import Array, jit


@jit
def panel_at(on: Any, s: float) -> int:
    """Return the panel that holds s; the last of those that have a width where s is beyond."""
    last = len(on.breaks_m) - 3
    for p in range(last):
        if s < on.breaks_m[p + 1]:
            return p
    return last if on.breaks_m[last + 1] > on.breaks_m[last] else last - 1


@jit
def touch(on: Any, clamp_rad: float, s_hat: float, q: Array, w: Scratch) -> None:
    """Write `w.hat`, `w.turn_hat` and `w.at` for the present shape."""
    here = panel_at(on, s_hat)
    low, half = on.breaks_m[here], 0.5 * (on.breaks_m[here + 1] - on.breaks_m[here])
    first, dof = on.first_node[here], on.first_dof[here]
    nodes, dofs = on.first_node[here + 1] - first, on.first_dof[here + 1] - dof
    for m in range(len(w.hat)):
        w.hat[m] = on.weight_m[m] if m < first else 0.0
    for j in range(len(q)):
        w.turn_hat[j] = 0.0
    for p in range(min(here, on.flexible)):
        w.turn_hat[on.first_dof[p]] = on.breaks_m[p + 1] - on.breaks_m[p]
    t = (s_hat - low) / half - 1.0
    before, P, k = 0.0, 1.0, 0.0  # P_(i - 1), P_i
    for i in range(nodes):
        over = w.over[i]
        after = (2.0 - over) * t * P - (1.0 - over) * before
        integral = half * (after - before + (1.0 if i == 0 else 0.0)) * w.over[2 * i]
        for m in range(nodes):
            w.hat[first + m] += integral * on.to_legendre[first + i, m]
        if i < dofs:
            w.turn_hat[dof + i] = integral
            k += P * q[dof + i]
        before, P = P, after
    phi, x, y = clamp_rad, 0.0, 0.0
    for j in range(len(q)):
        phi += w.turn_hat[j] * q[j]
    for m in range(first + nodes):
        x += w.hat[m] * w.cos[m]
        y += w.hat[m] * w.sin[m]
    w.at[0], w.at[1], w.at[2], w.at[3] = k, phi, x, y
    w.at[4], w.at[5] = -np.sin(phi), np.cos(phi)


@jit
def levers(angle: Array, w: Scratch) -> None:
    """Write J = n_hat . dr_hat/dq, T = t_hat . dr_hat/dq and d(J)/d(s_hat)."""
    w.J[:], w.T[:] = 0.0, 0.0
    nx, ny = w.at[4], w.at[5]
    for m in range(len(w.hat)):
        across = w.hat[m] * (-nx * w.sin[m] + ny * w.cos[m])
        along = w.hat[m] * (-ny * w.sin[m] - nx * w.cos[m])  # t_hat = (n_y, -n_x)
        for j in range(angle.shape[1]):
            w.J[j] += across * angle[m, j]
            w.T[j] += along * angle[m, j]
    for j in range(angle.shape[1]):
        w.slide[j] = w.turn_hat[j] - w.at[0] * w.T[j]
