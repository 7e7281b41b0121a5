"""The balance of moments: R_j = sum_m dphi_m/dq_j n_m . (force in the cut) + elastic - Me + N J_j.

Angles and their rates at the nodes, velocities, accelerations, forces of inertia and fluid, then
the force in the cut and the moment. Innermost loops run over all nodes, which processors take
several at a time. Functions are handed few arrays: each costs time.
"""

from __future__ import annotations

from typing import Any

from model.dynamics.kernel.work import (
    A_X,
    A_Y,
    COS,
    CUT_X,
    CUT_Y,
    E_X,
    E_Y,
    F_X,
    F_Y,
    HAT,
    PHI,
    RHS,
    SIN,
    SPIN,
    SWING,
    U_X,
    U_Y,
    V_X,
    V_Y,
)
from model.jit import Array, jit
from model.mechanics.kernel.lanes import sines


@jit
def spread(rows: Array, node: Array, given: int, out: int) -> None:
    """Write sum_i rows[i] x[i] and the same of y; there are a multiple of four rows.

    x and y are the rows `given` and `given` + 1 of `node`, the sums `out` and `out` + 1.
    """
    size = rows.shape[1]
    for i in range(0, rows.shape[0], 4):
        a, b, c, d = node[given, i], node[given, i + 1], node[given, i + 2], node[given, i + 3]
        e, f = node[given + 1, i], node[given + 1, i + 1]
        g, h = node[given + 1, i + 2], node[given + 1, i + 3]
        first = 0.0 if i == 0 else 1.0
        for m in range(size):
            p, q, r, s = rows[i, m], rows[i + 1, m], rows[i + 2, m], rows[i + 3, m]
            node[out, m] = first * node[out, m] + (p * a + q * b + r * c + s * d)
            node[out + 1, m] = first * node[out + 1, m] + (p * e + q * f + r * g + s * h)


@jit
def turn(rows: Array, q: Array, v: Array, a: Array, clamp: Array, node: Array) -> None:
    """Write angles, their rates and d/ds of the accelerations; clamp: psi, psi_t, psi_tt."""
    size = rows.shape[1]
    for m in range(size):
        node[PHI, m], node[SPIN, m], node[SWING, m] = clamp[0], clamp[1], clamp[2]
    for j in range(rows.shape[0]):
        turned, spun, swung = q[j], v[j], a[j]
        for m in range(size):
            share = rows[j, m]
            node[PHI, m] += share * turned
            node[SPIN, m] += share * spun
            node[SWING, m] += share * swung
    sines(node[PHI], node[SIN], node[COS])
    for m in range(size):
        sin, cos, swing = node[SIN, m], node[COS, m], node[SWING, m]
        square = node[SPIN, m] * node[SPIN, m]
        node[E_X, m] = -sin * swing - cos * square
        node[E_Y, m] = cos * swing - sin * square


@jit
def inertia(mass: Array, node: Array) -> None:
    """Write the forces of inertia."""
    for m in range(len(mass)):
        node[F_X, m] = mass[m] * node[A_X, m]
        node[F_Y, m] = mass[m] * node[A_Y, m]


@jit
def whirl(node: Array) -> None:
    """Write d/ds of the velocities."""
    for m in range(node.shape[1]):
        node[U_X, m] = -node[SIN, m] * node[SPIN, m]
        node[U_Y, m] = node[COS, m] * node[SPIN, m]


@jit
def fluid(load: Array, node: Array) -> None:
    """Add the fluid's forces; load: added mass, normal, quadratic and tangential drag."""
    for m in range(node.shape[1]):
        s, c = node[SIN, m], node[COS, m]
        across = -s * node[V_X, m] + c * node[V_Y, m]
        along = c * node[V_X, m] + s * node[V_Y, m]
        normal = load[0, m] * (-s * node[A_X, m] + c * node[A_Y, m])
        normal += (load[1, m] + load[2, m] * abs(across)) * across
        tangential = load[3, m] * along
        node[F_X, m] += -s * normal + c * tangential
        node[F_Y, m] += c * normal + s * tangential


@jit
def pressed(N: float, at: Array, node: Array) -> None:
    """Add the contact's force to that in the cut."""
    x, y = N * at[4], N * at[5]
    for m in range(node.shape[1]):
        node[CUT_X, m] += x * node[HAT, m]
        node[CUT_Y, m] += y * node[HAT, m]


@jit
def balance(rows: Array, node: Array, dof: Array) -> None:
    """Write the moments of the force in the cut."""
    size = rows.shape[1]
    for m in range(size):  # the moment; its row is free at this time
        node[E_X, m] = -node[SIN, m] * node[CUT_X, m] + node[COS, m] * node[CUT_Y, m]
    for j in range(rows.shape[0]):
        total = 0.0
        for m in range(size):
            total += rows[j, m] * node[E_X, m]
        dof[RHS, j] = total


@jit
def move(made: Any, q: Array, v: Array, a: Array, clamp: Array, node: Array) -> None:
    """Write everything at the nodes but the force in the cut."""
    turn(made.turn, q, v, a, clamp, node)
    spread(made.run, node, E_X, A_X)
    inertia(made.mass, node)
    if made.wet:
        whirl(node)
        spread(made.run, node, U_X, V_X)
        fluid(made.fluid, node)
    spread(made.back, node, F_X, CUT_X)
