"""The matrix of Newton's method: stiffness, inertia at large turn, fluid and contact.

With a' = factor_a q', v' = factor_v q' (generalized-alpha), all derivatives are exact. Left out,
those of inertia make steps of 1 ms diverge at large amplitudes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from model.dynamics.kernel.work import Scratch
from model.jit import jit


@jit
def integrate_columns(on: Any, row: int, w: Scratch) -> None:
    """Replace two rows of `w.by`, values at the nodes, by their integral from the clamp."""
    N = w.by.shape[2]
    w.start[:] = 0.0
    held = np.empty((2, w.cos.shape[0], N))
    for p in range(len(on.breaks_m) - 1):
        first, end = on.first_node[p], on.first_node[p + 1]
        for m in range(first, end):
            for c in range(2):
                for k in range(N):
                    held[c, m, k] = w.start[c, k]
                for i in range(end - first):
                    share = on.run[m, i]
                    for k in range(N):
                        held[c, m, k] += share * w.by[row + c, first + i, k]
        for m in range(first, end):
            for c in range(2):
                for k in range(N):
                    w.start[c, k] += on.weight_m[m] * w.by[row + c, m, k]
    for c in range(2):
        w.by[row + c] = held[c]


@jit
def derivatives(body: Any, factor_v: float, factor_a: float, w: Scratch) -> None:
    """Write `w.by`: how places, velocities and accelerations at the nodes change with q."""
    for m in range(len(w.sin)):
        s, c, spin, swing = w.sin[m], w.cos[m], w.spin[m], w.swing[m]
        along, across = factor_a - spin * spin, swing + 2.0 * factor_v * spin
        for k in range(body.angle.shape[1]):
            phi = body.angle[m, k]
            w.by[0, m, k], w.by[1, m, k] = -s * phi, c * phi
            w.by[4, m, k] = (-s * along - c * across) * phi
            w.by[5, m, k] = (c * along - s * across) * phi
            if body.wet:
                w.by[2, m, k] = (-s * factor_v - c * spin) * phi
                w.by[3, m, k] = (c * factor_v - s * spin) * phi
    integrate_columns(body.space, 0, w)
    integrate_columns(body.space, 4, w)
    if body.wet:
        integrate_columns(body.space, 2, w)


@jit
def forces(body: Any, m: int, w: Scratch) -> None:
    """Write `w.push`: how the force at a node changes with q."""
    for k in range(body.angle.shape[1]):
        w.push[0, k] = body.mass[m] * w.by[4, m, k]
        w.push[1, k] = body.mass[m] * w.by[5, m, k]
    if body.wet:
        s, c = w.sin[m], w.cos[m]
        across = -s * w.velocity[0, m] + c * w.velocity[1, m]
        along = c * w.velocity[0, m] + s * w.velocity[1, m]
        forward = c * w.acceleration[0, m] + s * w.acceleration[1, m]
        drag = body.normal[m] + 2.0 * body.quadratic[m] * abs(across)
        normal = body.added[m] * (-s * w.acceleration[0, m] + c * w.acceleration[1, m])
        normal += (body.normal[m] + body.quadratic[m] * abs(across)) * across
        rub = body.tangential[m]
        for k in range(body.angle.shape[1]):
            phi = body.angle[m, k]
            d_across = -s * w.by[2, m, k] + c * w.by[3, m, k] - along * phi
            d_along = c * w.by[2, m, k] + s * w.by[3, m, k] + across * phi
            d_normal = body.added[m] * (-s * w.by[4, m, k] + c * w.by[5, m, k] - forward * phi)
            d_normal += drag * d_across + rub * along * phi
            d_tangential = rub * d_along - normal * phi
            w.push[0, k] += -s * d_normal + c * d_tangential
            w.push[1, k] += c * d_normal + s * d_tangential


@jit
def assemble(body: Any, elastic: float, N: float, contact: bool, w: Scratch) -> int:
    """Write `w.matrix`, bordered by J where there is contact; return its size."""
    size: int = body.angle.shape[1]
    w.matrix[:] = 0.0
    for m in range(len(w.sin)):
        forces(body, m, w)
        bend = -w.cos[m] * w.cut[0, m] - w.sin[m] * w.cut[1, m]
        for j in range(size):
            x, y, turn = w.by[0, m, j], w.by[1, m, j], bend * body.angle[m, j]
            for k in range(size):
                w.matrix[j, k] += x * w.push[0, k] + y * w.push[1, k] + turn * body.angle[m, k]
    for j in range(size):
        w.matrix[j, j] += elastic * body.stiffness[j]
    if not contact:
        return size
    for j in range(size):
        for k in range(size):
            w.matrix[j, k] -= N * (w.T[j] * w.turn_hat[k] + w.slide[j] * w.T[k])
        w.matrix[j, size] = w.matrix[size, j] = w.J[j]
    return size + 1


@jit
def invert(size: int, w: Scratch) -> bool:
    """Write the inverse of the matrix (Gauss-Jordan, pivots by row); False where it is singular."""
    A, B = w.matrix, w.inverse
    B[:] = 0.0
    for j in range(size):
        B[j, j] = 1.0
    for j in range(size):
        pivot = j
        for i in range(j + 1, size):
            if abs(A[i, j]) > abs(A[pivot, j]):
                pivot = i
        if not abs(A[pivot, j]) > 0.0:
            return False
        for k in range(size):
            A[j, k], A[pivot, k] = A[pivot, k], A[j, k]
            B[j, k], B[pivot, k] = B[pivot, k], B[j, k]
        over = 1.0 / A[j, j]
        for k in range(size):
            A[j, k] *= over
            B[j, k] *= over
        for i in range(size):
            if i != j:
                share = A[i, j]
                for k in range(size):
                    A[i, k] -= share * A[j, k]
                    B[i, k] -= share * B[j, k]
    return True
