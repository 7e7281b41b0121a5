"""The balance of moments: R_j = sum_m dphi_m/dq_j n_m . (force in the cut) + elastic - Me + N J_j.

Panel after panel from the clamp: angles and their rates at the nodes, velocities, accelerations,
the forces of inertia and fluid; then back from the end: the force in the cut, the moment.
"""

from __future__ import annotations

from typing import Any

from model.dynamics.kernel.work import Scratch
from model.jit import Array, jit
from model.mechanics.kernel.lanes import sines


@jit
def integrate(on: Any, e: Array, out: Array) -> None:
    """Write the integral from the clamp of values at the nodes; x and y are rows 0 and 1."""
    start_x, start_y = 0.0, 0.0
    for p in range(len(on.breaks_m) - 1):
        first, end = on.first_node[p], on.first_node[p + 1]
        for m in range(first, end):
            x, y = start_x, start_y
            for i in range(end - first):
                x += on.run[m, i] * e[0, first + i]
                y += on.run[m, i] * e[1, first + i]
            out[0, m], out[1, m] = x, y
        for m in range(first, end):
            start_x += on.weight_m[m] * e[0, m]
            start_y += on.weight_m[m] * e[1, m]


@jit
def fluid(body: Any, w: Scratch) -> None:
    """Write velocities at the nodes, and add the fluid's forces to those of inertia."""
    for m in range(len(w.sin)):
        w.e[0, m], w.e[1, m] = -w.sin[m] * w.spin[m], w.cos[m] * w.spin[m]
    integrate(body.space, w.e, w.velocity)
    for m in range(len(w.sin)):
        s, c = w.sin[m], w.cos[m]
        across = -s * w.velocity[0, m] + c * w.velocity[1, m]
        along = c * w.velocity[0, m] + s * w.velocity[1, m]
        normal = body.added[m] * (-s * w.acceleration[0, m] + c * w.acceleration[1, m])
        normal += (body.normal[m] + body.quadratic[m] * abs(across)) * across
        tangential = body.tangential[m] * along
        w.force[0, m] += -s * normal + c * tangential
        w.force[1, m] += c * normal + s * tangential


@jit
def move(body: Any, q: Array, v: Array, a: Array, clamp: Array, w: Scratch) -> None:
    """Write angles, accelerations and forces at the nodes; clamp: psi, psi_t, psi_tt.

    Each call that is handed all arrays costs as much as a panel, so this is one function.
    """
    on = body.space
    phi, spin, swing = clamp[0], clamp[1], clamp[2]
    for p in range(len(on.breaks_m) - 1):
        dof, dofs = on.first_dof[p], on.first_dof[p + 1] - on.first_dof[p]
        for m in range(on.first_node[p], on.first_node[p + 1]):
            turned, spun, swung = phi, spin, swing
            for j in range(dofs):
                turned += on.turn[m, j] * q[dof + j]
                spun += on.turn[m, j] * v[dof + j]
                swung += on.turn[m, j] * a[dof + j]
            w.phi[m], w.spin[m], w.swing[m] = turned, spun, swung
        if dofs > 0:
            h = on.breaks_m[p + 1] - on.breaks_m[p]
            phi, spin, swing = phi + h * q[dof], spin + h * v[dof], swing + h * a[dof]
    sines(w.phi, w.sin, w.cos)
    for m in range(len(w.sin)):
        square = w.spin[m] * w.spin[m]
        w.e[0, m] = -w.sin[m] * w.swing[m] - w.cos[m] * square
        w.e[1, m] = w.cos[m] * w.swing[m] - w.sin[m] * square
    start_x, start_y = 0.0, 0.0
    for p in range(len(on.breaks_m) - 1):
        first, end = on.first_node[p], on.first_node[p + 1]
        for m in range(first, end):
            x, y = start_x, start_y
            for i in range(end - first):
                x += on.run[m, i] * w.e[0, first + i]
                y += on.run[m, i] * w.e[1, first + i]
            w.acceleration[0, m], w.acceleration[1, m] = x, y
            w.force[0, m], w.force[1, m] = body.mass[m] * x, body.mass[m] * y
        for m in range(first, end):
            start_x += on.weight_m[m] * w.e[0, m]
            start_y += on.weight_m[m] * w.e[1, m]
    if body.wet:
        fluid(body, w)


@jit
def balance(body: Any, N: float, contact: bool, out: Array, w: Scratch) -> None:
    """Write the moments of inertia, fluid and contact (coefficients' part) to `out` (N,)."""
    on = body.space
    x, y, later = 0.0, 0.0, 0.0  # force and moment of the panels beyond
    for p in range(len(on.breaks_m) - 2, -1, -1):
        first, end = on.first_node[p], on.first_node[p + 1]
        dof, dofs = on.first_dof[p], on.first_dof[p + 1] - on.first_dof[p]
        nodes = end - first
        for m in range(first, end):
            w.cut[0, m], w.cut[1, m] = on.weight_m[m] * x, on.weight_m[m] * y
        for m in range(first, end):
            for i in range(nodes):
                w.cut[0, first + i] += on.run[m, i] * w.force[0, m]
                w.cut[1, first + i] += on.run[m, i] * w.force[1, m]
        if contact:
            for m in range(first, end):
                w.cut[0, m] += N * w.hat[m] * w.at[4]
                w.cut[1, m] += N * w.hat[m] * w.at[5]
        for j in range(dofs):
            out[dof + j] = 0.0
        if dofs > 0:
            out[dof] = later * (on.breaks_m[p + 1] - on.breaks_m[p])
        for m in range(first, end):
            x += w.force[0, m]
            y += w.force[1, m]
            moment = -w.sin[m] * w.cut[0, m] + w.cos[m] * w.cut[1, m]
            later += moment
            for j in range(dofs):
                out[dof + j] += on.turn[m, j] * moment
