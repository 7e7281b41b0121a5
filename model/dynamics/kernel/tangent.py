"""The matrix of Newton's method: stiffness, inertia at large turn, fluid and contact.

With a' = factor_a q', v' = factor_v q' (generalized-alpha), all derivatives are exact. Left out,
those of inertia make steps of 1 ms diverge at large amplitudes.
"""

from __future__ import annotations

from typing import Any

from model.dynamics.kernel.work import (
    A_X,
    A_Y,
    ALONG,
    BEND,
    COS,
    CUT_X,
    CUT_Y,
    D_A,
    D_R,
    D_V,
    FORCE,
    SIN,
    SLIDE,
    SPIN,
    SWING,
    TURN_HAT,
    V_X,
    V_Y,
    A,
    J,
    R,
    Scratch,
    V,
)
from model.jit import Array, jit


@jit
def rates(angle: Array, factor_v: float, factor_a: float, node: Array, by: Array) -> None:
    """Write d/ds of how places, accelerations and velocities change."""
    for m in range(node.shape[1]):
        s, c, spin, swing = node[SIN, m], node[COS, m], node[SPIN, m], node[SWING, m]
        along, across = factor_a - spin * spin, swing + 2.0 * factor_v * spin
        ax, ay = -s * along - c * across, c * along - s * across
        vx, vy = -s * factor_v - c * spin, c * factor_v - s * spin
        for k in range(angle.shape[1]):
            phi = angle[m, k]
            by[D_R, m, k], by[D_R + 1, m, k] = -s * phi, c * phi
            by[D_A, m, k], by[D_A + 1, m, k] = ax * phi, ay * phi
            by[D_V, m, k], by[D_V + 1, m, k] = vx * phi, vy * phi


@jit
def integrate(run: Array, given: Array, out: Array) -> None:
    """Write the integral from the clamp of values at the nodes, for each coefficient."""
    for m in range(given.shape[0]):
        for k in range(given.shape[1]):
            out[m, k] = 0.0
        for i in range(0, given.shape[0], 4):
            a, b, c, d = run[i, m], run[i + 1, m], run[i + 2, m], run[i + 3, m]
            if a == 0.0 and d == 0.0:  # a panel beyond
                continue
            for k in range(given.shape[1]):
                out[m, k] += (a * given[i, k] + b * given[i + 1, k]) + (
                    c * given[i + 2, k] + d * given[i + 3, k]
                )


@jit
def forces(mass: Array, by: Array) -> None:
    """Write how the forces of inertia change."""
    for m in range(by.shape[1]):
        for k in range(by.shape[2]):
            by[FORCE, m, k] = mass[m] * by[A, m, k]
            by[FORCE + 1, m, k] = mass[m] * by[A + 1, m, k]


@jit
def fluid(angle: Array, load: Array, node: Array, by: Array) -> None:
    """Add how the fluid's forces change; load: added mass, normal, quadratic, tangential drag."""
    for m in range(node.shape[1]):
        s, c, added, rub = node[SIN, m], node[COS, m], load[0, m], load[3, m]
        across = -s * node[V_X, m] + c * node[V_Y, m]
        along = c * node[V_X, m] + s * node[V_Y, m]
        forward = c * node[A_X, m] + s * node[A_Y, m]
        drag = load[1, m] + 2.0 * load[2, m] * abs(across)
        normal = added * (-s * node[A_X, m] + c * node[A_Y, m])
        normal += (load[1, m] + load[2, m] * abs(across)) * across
        for k in range(angle.shape[1]):
            phi = angle[m, k]
            d_across = -s * by[V, m, k] + c * by[V + 1, m, k] - along * phi
            d_along = c * by[V, m, k] + s * by[V + 1, m, k] + across * phi
            d_normal = added * (-s * by[A, m, k] + c * by[A + 1, m, k] - forward * phi)
            d_normal += drag * d_across + rub * along * phi
            d_tangential = rub * d_along - normal * phi
            by[FORCE, m, k] += -s * d_normal + c * d_tangential
            by[FORCE + 1, m, k] += c * d_normal + s * d_tangential


@jit
def bends(angle: Array, node: Array, by: Array) -> None:
    """Write how the moment changes as the node turns under the force in the cut."""
    for m in range(node.shape[1]):
        bend = -node[COS, m] * node[CUT_X, m] - node[SIN, m] * node[CUT_Y, m]
        for k in range(angle.shape[1]):
            by[BEND, m, k] = bend * angle[m, k]


@jit
def add(left: Array, right: Array, out: Array) -> None:
    """Add left^T right; there are a multiple of four rows."""
    for j in range(len(out) - 1):
        for m in range(0, left.shape[0], 4):
            a, b, c, d = left[m, j], left[m + 1, j], left[m + 2, j], left[m + 3, j]
            for k in range(left.shape[1]):
                out[j, k] += (a * right[m, k] + b * right[m + 1, k]) + (
                    c * right[m + 2, k] + d * right[m + 3, k]
                )


@jit
def edge(elastic: float, stiffness: Array, N: float, contact: bool, dof: Array, out: Array) -> int:
    """Add elasticity and contact; return the matrix's size."""
    size = len(stiffness)
    for j in range(size):
        out[j, j] += elastic * stiffness[j]
    if not contact:
        return size
    for k in range(out.shape[1]):
        out[size, k] = 0.0
    for j in range(size):
        for k in range(size):
            turned = dof[ALONG, j] * dof[TURN_HAT, k] + dof[SLIDE, j] * dof[ALONG, k]
            out[j, k] -= N * turned
        out[j, size] = out[size, j] = dof[J, j]
    return size + 1


@jit
def assemble(made: Any, by_q: Array, w: Scratch) -> None:
    """Write what inertia and fluid add to `w.matrix`; by_q: dv/dq, da/dq."""
    node, by, matrix = w.node, w.by, w.matrix
    rates(made.angle, by_q[0], by_q[1], node, by)
    for plane in range(4):
        integrate(made.run, by[plane], by[R + plane])
    forces(made.mass, by)
    if made.wet:
        integrate(made.run, by[D_V], by[V])
        integrate(made.run, by[D_V + 1], by[V + 1])
        fluid(made.angle, made.fluid, node, by)
    bends(made.angle, node, by)
    for j in range(matrix.shape[0]):
        for k in range(matrix.shape[1]):
            matrix[j, k] = 0.0
    add(by[R], by[FORCE], matrix)
    add(by[R + 1], by[FORCE + 1], matrix)
    add(made.angle, by[BEND], matrix)


@jit
def pivot(size: int, j: int, rows: Array) -> bool:
    """Put the largest value of column j in row j, and make it 1; False where there is none."""
    best = j
    for i in range(j + 1, size):
        if abs(rows[i, j]) > abs(rows[best, j]):
            best = i
    if not abs(rows[best, j]) > 0.0:
        return False
    if best != j:
        for k in range(rows.shape[1]):
            rows[j, k], rows[best, k] = rows[best, k], rows[j, k]
    over = 1.0 / rows[j, j]
    for k in range(rows.shape[1]):
        rows[j, k] *= over
    return True


@jit
def invert(size: int, rows: Array, inverse: Array) -> bool:
    """Write the inverse of a matrix (Gauss-Jordan, pivots by row); False where it is singular.

    The matrix is the left part of `rows`; the right part is used. A row of `inverse` belongs to a
    residual.
    """
    right = rows.shape[1] - rows.shape[0]
    for j in range(size):
        for k in range(size, rows.shape[1]):
            rows[j, k] = 0.0
        rows[j, right + j] = 1.0
    for j in range(size):
        if not pivot(size, j, rows):
            return False
        for i in range(size):
            if i != j:
                share = rows[i, j]
                for k in range(rows.shape[1]):
                    rows[i, k] -= share * rows[j, k]
    for j in range(size):
        for k in range(size):
            inverse[k, j] = rows[j, right + k]
    return True
