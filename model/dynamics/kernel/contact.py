"""The sheet where the rolls touch it: s_hat, its angle and place, and how these follow from q."""

from __future__ import annotations

from typing import Any

import numpy as np

from model.dynamics.kernel.work import ALONG, COS, HAT, SIN, SLIDE, TURN_HAT, J, Scratch
from model.jit import Array, jit


@jit
def panel_at(breaks_m: Array, s: float) -> int:
    """Return the panel that holds s; the last of those that have a width where s is beyond."""
    last = len(breaks_m) - 3
    for p in range(last):
        if s < breaks_m[p + 1]:
            return p
    return last if breaks_m[last + 1] > breaks_m[last] else last - 1


@jit
def legendre(t: float, half: float, over: Array, values: Array, integrals: Array) -> None:
    """Write P_i(t), and half times its integral from -1; over: 1/(i + 1)."""
    before, P = 0.0, 1.0  # P_(i - 1), P_i
    for i in range(len(values)):
        share = over[i]
        after = (2.0 - share) * t * P - (1.0 - share) * before
        integrals[i] = half * (after - before + (1.0 if i == 0 else 0.0)) * over[2 * i]
        values[i] = P
        before, P = P, after


@jit
def reach(weight_m: Array, rows: Array, integrals: Array, first: int, hat: Array) -> None:
    """Write the weights of the integral up to s_hat; rows: to Legendre, of the panel from first."""
    for m in range(len(hat)):
        hat[m] = weight_m[m] if m < first else 0.0
    size, n = rows.shape[1], len(integrals)
    of = hat[first : first + size]
    for i in range(0, n - 1, 2):
        a, b = integrals[i], integrals[i + 1]
        for m in range(size):
            of[m] += a * rows[i, m] + b * rows[i + 1, m]
    if n % 2:
        a = integrals[n - 1]
        for m in range(size):
            of[m] += a * rows[n - 1, m]


@jit
def touch(made: Any, clamp_rad: float, s_hat: float, q: Array, w: Scratch) -> None:
    """Write `w.at` and the rows HAT and TURN_HAT for the present shape."""
    at, node, dof, integrals, values = w.at, w.node, w.dof, w.integrals, w.values
    here = panel_at(made.breaks_m, s_hat)
    low, half = made.breaks_m[here], 0.5 * (made.breaks_m[here + 1] - made.breaks_m[here])
    first, own = made.first_node[here], made.first_dof[here]
    nodes, dofs = made.first_node[here + 1] - first, made.first_dof[here + 1] - own
    legendre((s_hat - low) / half - 1.0, half, w.over, values[:nodes], integrals[:nodes])
    reach(
        made.weight_m, made.to_legendre[first : first + nodes, :nodes], integrals[:nodes], first,
        node[HAT],
    )  # fmt: skip
    k, phi = 0.0, clamp_rad
    for j in range(len(q)):
        dof[TURN_HAT, j] = 0.0
    for p in range(min(here, made.flexible)):
        dof[TURN_HAT, made.first_dof[p]] = made.breaks_m[p + 1] - made.breaks_m[p]
    for i in range(dofs):
        dof[TURN_HAT, own + i] = integrals[i]
        k += values[i] * q[own + i]
    for j in range(len(q)):
        phi += dof[TURN_HAT, j] * q[j]
    x, y = 0.0, 0.0
    for m in range(node.shape[1]):
        x += node[HAT, m] * node[COS, m]
        y += node[HAT, m] * node[SIN, m]
    at[0], at[1], at[2], at[3] = k, phi, x, y
    at[4], at[5] = -np.sin(phi), np.cos(phi)


@jit
def levers(rows: Array, at: Array, node: Array, dof: Array) -> None:
    """Write J, ALONG and d(J)/d(s_hat)."""
    nx, ny = at[4], at[5]
    for j in range(rows.shape[0]):
        across, along = 0.0, 0.0
        for m in range(rows.shape[1]):
            share = node[HAT, m] * rows[j, m]
            across += share * (-nx * node[SIN, m] + ny * node[COS, m])
            along += share * (-ny * node[SIN, m] - nx * node[COS, m])  # t_hat = (n_y, -n_x)
        dof[J, j], dof[ALONG, j] = across, along
        dof[SLIDE, j] = dof[TURN_HAT, j] - at[0] * along
