"""Small motions about a state at rest: modes, transfer functions, a state space.

About the state (q, N, s_hat) the equations become
    [p^2 M + p C + B*(p)/B K + G, g_N, g_s; E_q, 0, E_s] [dq; dN; ds] = [int dMe P_j; dp_hat].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.dynamics.body import Body
from model.dynamics.equations import Motions, Numbers, at_contact, derivative, moments
from model.dynamics.line import LineModes
from model.dynamics.material import Viscoelasticity
from model.dynamics.motion import Simulation
from model.dynamics.space import Rows, rows_at
from model.dynamics.space import moments as projection
from model.measurements import FloatArray, ModelError


@dataclass(frozen=True, kw_only=True)
class SmallMotion:
    """The equations about a state at rest. N coefficients; c = 2 in contact, else 0."""

    body: Body
    material: Viscoelasticity
    line: LineModes | None
    moment_per_volt_Nm: FloatArray  # at each node, by the sign of the voltage there
    mass: FloatArray  # (N, N)
    damping: FloatArray  # (N, N) of the fluid
    geometric: FloatArray  # (N, N) of the contact force
    of_contact: FloatArray  # (N, c) moments by dN and ds_hat
    closure: FloatArray  # (2 or 0, N + c) dr_hat by dq, dN, ds_hat
    force: FloatArray  # (N + c,) dF by the same
    shape: tuple[FloatArray, FloatArray]  # sin and cos of phi at the nodes

    @property
    def contact(self) -> bool:
        """Whether the rolls hold the sheet."""
        return bool(self.of_contact.shape[1])

    @cached_property
    def free_directions(self) -> FloatArray:
        """Return an orthonormal basis (N, N - 1) of what the contact allows; all without one."""
        if not self.contact:
            return np.eye(self.body.space.size)
        across = self._across
        return np.asarray(np.linalg.svd(across[None])[2][1:].T)

    @cached_property
    def stiffness(self) -> FloatArray:
        """Return the relaxed stiffness (N, N) with s_hat eliminated, of the free directions."""
        K = np.diag(self.body.stiffness) + self.geometric
        if self.contact:
            K = K + np.outer(self.of_contact[:, 1], self._slip)
        return K

    @property
    def _across(self) -> FloatArray:
        """Return J: how the sheet at the rolls moves along the normal."""
        along = self.closure[:, -1]
        return np.asarray(along[0] * self.closure[1, :-2] - along[1] * self.closure[0, :-2])

    @property
    def _slip(self) -> FloatArray:
        """Return ds_hat/dq."""
        along = self.closure[:, -1]
        return np.asarray(-(along @ self.closure[:, :-2]) / (along @ along))

    @cached_property
    def _eigen(self) -> tuple[FloatArray, FloatArray]:
        from scipy.linalg import eigh

        Z = self.free_directions
        K = Z.T @ (0.5 * (self.stiffness + self.stiffness.T)) @ Z
        squares, modes = eigh(K, Z.T @ self.mass @ Z)
        return squares, Z @ modes

    def frequencies_hz(self) -> FloatArray:
        """Return the undamped frequencies with the relaxed stiffness, ascending."""
        return np.asarray(np.sqrt(np.maximum(self._eigen[0], 0.0)) / (2.0 * np.pi))

    def modes(self) -> FloatArray:
        """Return their coefficients (N, modes), of unit modal mass."""
        return self._eigen[1]

    def respond(self, p: complex, moment: Numbers) -> Numbers:
        """Return (dq, dN, ds_hat) exp(p t) for int dMe P_j ds exp(p t), (N,)."""
        N, c = self.of_contact.shape
        A = np.zeros((N + c, N + c), dtype=complex)
        stiff = self.material.complex_stiffness(p) / self.material.B_Nm2
        A[:N, :N] = p * p * self.mass + p * self.damping + self.geometric
        A[:N, :N] += stiff * np.diag(self.body.stiffness)
        A[:N, N:], A[N:, :] = self.of_contact, self.closure
        return np.asarray(np.linalg.solve(A, np.concatenate([moment, np.zeros(c)])))

    def transfer(self, p: complex, s_m: FloatArray) -> tuple[Numbers, Numbers, complex, complex]:
        """Return x(s)/V, y(s)/V (S,), force/V and current/V of the source at exp(p t)."""
        if self.line is None:
            raise ModelError("a transfer function from voltage needs the sheet's electrodes")
        modes = self.line.transfer(p)
        U = self.line.at(np.minimum(self.body.space.s_m, self.line.length_m)) @ modes
        answer = self.respond(p, projection(self.body.space) @ (self.moment_per_volt_Nm * U))
        x, y = self.places(rows_at(self.body.space, s_m))
        N = self.body.space.size
        clamp = complex(self.line.clamp_V(modes[None], np.ones(1))[0])
        current = (1.0 - clamp) / self.line.line.source_ohm
        return x @ answer[:N], y @ answer[:N], complex(self.force @ answer), current

    def places(self, rows: Rows) -> tuple[FloatArray, FloatArray]:
        """Return dx/dq and dy/dq at points, (S, N) each."""
        sin, cos = self.shape
        return (
            rows.position @ (-sin[:, None] * self.body.angle),
            rows.position @ (cos[:, None] * self.body.angle),
        )


def linearise(of: Simulation) -> SmallMotion:
    """Return the small motions about the state of a simulation that is at rest.

    Where the sheet is at 0 V, its moment per volt is the mean of those for U > 0 and U < 0.
    """
    body, state, contact = of.body, of.state, of.setup is not None
    if np.max(np.abs(state.v)) * body.space.length_m > 1e-6:
        raise ModelError("only about a state at rest can the motion be linearised")
    size, psi = body.space.size, of.clamp_at(of.time_s)
    rest = np.array([psi[0], 0.0, 0.0])

    def turned(u: Numbers) -> Numbers:
        """Return moments and place of the contact for u = (q, N, s_hat, v, a)."""
        q, v, a = u[:, :size], u[:, size + 2 : 2 * size + 2], u[:, 2 * size + 2 :]
        at = Motions(q, v, a, u[:, size], u[:, size + 1])
        return np.concatenate(moments(body, at, rest, contact), axis=1)

    u = np.concatenate([state.q, state.x[:2], np.zeros(2 * size)])
    D = derivative(turned, u)
    c = 2 if contact else 0
    phi = body.angle @ state.q + psi[0]
    return SmallMotion(
        body=body, material=of.beam.material, line=of.line,
        moment_per_volt_Nm=of.moment_per_volt_Nm, mass=D[:size, 2 * size + 2 :],
        damping=D[:size, size + 2 : 2 * size + 2], geometric=D[:size, :size],
        of_contact=D[:size, size : size + c], closure=D[size : size + c, : size + c],
        force=_force(of, size), shape=(np.sin(phi), np.cos(phi)),
    )  # fmt: skip


def _force(of: Simulation, size: int) -> FloatArray:
    """Return dF by (dq, dN, ds_hat), F = N cos(gamma)."""
    if of.setup is None:
        return np.zeros(size)
    beta = float(of.setup.angles(np.array([of.time_s]))[0])
    psi = float(of.clamp_at(of.time_s)[0])

    def force(u: Numbers) -> Numbers:
        turn, _ = at_contact(of.body.space, u[:, size + 1])
        gamma = (turn * u[:, :size]).sum(1) + psi - beta
        return np.asarray((u[:, size] * np.cos(gamma))[:, None])

    return np.asarray(derivative(force, np.concatenate([of.state.q, of.state.x[:2]]))[0])
