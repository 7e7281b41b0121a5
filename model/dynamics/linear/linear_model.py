"""The sheet as a linear model in state space, about a state at rest.

States: the motions that the contact allows, their velocities, one internal variable of each for
every Prony term, and the modes of the line. With the small motion's equations (`linearised`),
    M q'' + (C + eta K) q' + ((1 + sum g_i) K + G) q - sum g_i K z_i + c dN = Q u,
    tau_i z_i' = q - z_i,   u' = -rates (u - final V),
c the moments by dN, which do no work on the allowed motions, and Q u those of Me = alpha U.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.dynamics.line import LineModes
from model.dynamics.linear.state_space import LinearSystem
from model.dynamics.linearised import SmallMotion
from model.dynamics.space import moments, rows_at
from model.measurements import FloatArray, ModelError

OUTPUTS = ("force_N", "tip_m", "current_A")


def linear_model(small: SmallMotion) -> LinearSystem:
    """Return the model from the source's voltage_V to force_N, tip_m and current_A.

    The force is F along the arc's tangent, 0 of a free sheet; the tip is the end of sheet or
    elongation, measured along its normal. About 0 V the moment per volt is the mean of those for
    both signs. Raises ModelError for a sheet without electrodes.
    """
    if small.line is None:
        raise ModelError("a linear model from voltage needs the sheet's electrodes")
    parts = _parts(small, small.line)
    m, modes, size = parts.allowed, small.line.terms, parts.size
    q, v, u = slice(0, m), slice(m, 2 * m), slice(size - modes, size)
    Z = small.free_directions
    A, B = np.zeros((size, size)), np.zeros((size, 1))
    A[q, v] = np.eye(m)
    A[v] = np.linalg.solve(Z.T @ small.mass @ Z, Z.T @ parts.moments)
    for i, time_s in enumerate(small.material.times_s):
        z = slice((2 + i) * m, (3 + i) * m)
        A[z, q], A[z, z] = np.eye(m) / time_s, -np.eye(m) / time_s
    rates = small.line.rates_per_s
    final = small.line.respond(np.zeros(modes), np.array([np.inf]), np.ones(1))[1]  # at 1 V
    A[u, u], B[u, 0] = -np.diag(rates), rates * final
    C, D = np.zeros((3, size)), np.zeros((3, 1))
    C[0] = _force(small, parts, A[v])
    C[1, q] = _across(small) @ Z
    C[2, u] = small.line.current_A(np.eye(modes), np.zeros(modes))
    D[2] = small.line.current_A(np.zeros((1, modes)), np.ones(1))
    return LinearSystem(A=A, B=B, C=C, D=D, inputs=("voltage_V",), outputs=OUTPUTS)


def read_by(system: LinearSystem, resonance_hz: float, damping: float) -> LinearSystem:
    """Return the model with force_N as a load cell of this resonance and damping ratio reads it.

    The cell is so much stiffer than the sheet that it follows without acting back.
    """
    if not (0.0 < resonance_hz < np.inf and 0.0 <= damping < np.inf):
        raise ModelError(
            "a load cell's resonance must be positive and its damping zero or positive,"
            f" not {resonance_hz:g} Hz and {damping:g}"
        )
    w, n = 2.0 * np.pi * resonance_hz, system.order
    force = system.outputs.index("force_N")
    A = np.zeros((n + 2, n + 2))
    A[:n, :n] = system.A
    A[n, n + 1] = 1.0
    A[n + 1, :n] = w**2 * system.C[force]
    A[n + 1, n:] = -(w**2), -2.0 * damping * w
    B = np.vstack([system.B, np.zeros((1, system.B.shape[1])), w**2 * system.D[force]])
    C, D = np.hstack([system.C, np.zeros((len(system.C), 2))]), system.D.copy()
    C[force], D[force] = np.eye(n + 2)[n], 0.0
    return replace(system, A=A, B=B, C=C, D=D)


@dataclass(frozen=True)
class _Parts:
    """How the states load the N coefficients of the curvature."""

    moments: FloatArray  # (N, size): all but inertia and dN, on the right-hand side
    allowed: int  # motions
    slip: FloatArray  # (N,) ds_hat/dq

    @property
    def size(self) -> int:
        """Return the number of states."""
        return int(self.moments.shape[1])


def _parts(small: SmallMotion, line: LineModes) -> _Parts:
    material, Z = small.material, small.free_directions
    m, prony = Z.shape[1], len(material.shares)
    K, G, slip = np.diag(small.body.stiffness), small.geometric, np.zeros(len(Z))
    if small.contact:
        along = small.closure[:, -1]
        slip = -(along @ small.closure[:, :-2]) / (along @ along)
        G = G + np.outer(small.of_contact[:, 1], slip)
    rows = np.zeros((len(Z), (2 + prony) * m + line.terms))
    rows[:, :m] = -((1.0 + sum(material.shares)) * K + G) @ Z
    rows[:, m : 2 * m] = -(material.viscous_time_s * K + small.damping) @ Z
    for i, share in enumerate(material.shares):
        rows[:, (2 + i) * m : (3 + i) * m] = share * K @ Z
    on = small.body.space
    U = line.at(np.minimum(on.s_m, line.length_m))
    rows[:, -line.terms :] = moments(on) @ (small.moment_per_volt_Nm[:, None] * U)
    return _Parts(rows, m, slip)


def _force(small: SmallMotion, parts: _Parts, accelerations: FloatArray) -> FloatArray:
    """Return dF of the states: dN is what the equation of motion leaves along its own moments."""
    if not small.contact:
        return np.zeros(parts.size)
    Z, by_N = small.free_directions, small.of_contact[:, 0]
    left = parts.moments - small.mass @ Z @ accelerations
    row = np.asarray(small.force[-2] * (by_N @ left) / (by_N @ by_N))
    row[: parts.allowed] += (small.force[:-2] + small.force[-1] * parts.slip) @ Z
    return row


def _across(small: SmallMotion) -> FloatArray:
    """Return how the end of all moves along its normal by dq, (N,)."""
    on = small.body.space
    x, y = small.places(rows_at(on, on.breaks_m[-1:]))
    sin, cos = small.shape[0][-1], small.shape[1][-1]
    return np.asarray(-sin * x[0] + cos * y[0])
