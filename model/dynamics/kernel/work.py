"""Scratch arrays of one march."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from model.jit import Array, jit

# Rows of `Scratch.node`, a value for each node.
PHI, SPIN, SWING = 0, 1, 2  # the angle and its two derivatives in time
SIN, COS = 3, 4
E_X, E_Y, A_X, A_Y = 5, 6, 7, 8  # d/ds of the acceleration, and the acceleration
U_X, U_Y, V_X, V_Y = 9, 10, 11, 12  # d/ds of the velocity, and the velocity
F_X, F_Y = 13, 14  # forces of inertia and fluid
CUT_X, CUT_Y = 15, 16  # the force in the cut, times the node's weight
HAT = 17  # nodal values -> their integral up to s_hat
ROWS = 18
# Rows of `Scratch.dof`, a value for each coefficient; the place along n_hat comes last.
RHS, STEP, HISTORY = 0, 1, 2  # residuals' negative; Newton's step; the past of the Prony series
TURN_HAT = 3  # coefficients -> phi_hat
J, ALONG = 4, 5  # n_hat . dr_hat/dq, t_hat . dr_hat/dq
SLIDE = 6  # how the contact's moment changes with s_hat, over N
FORMER = 7  # d2q/dt2 at the end of the step before
DOF_ROWS = 8


# Planes of `Scratch.by`: how what is at the nodes changes with each coefficient; y follows x.
D_R, D_A, D_V = 0, 2, 4  # d/ds of the place, the acceleration and the velocity
R, A, V = 6, 8, 10  # these themselves
FORCE, BEND = 12, 14  # the force at a node; the moment there, as the force in the cut turns
PLANES = 15


class Scratch(NamedTuple):
    """M nodes, N coefficients; P: N, rounded up to a multiple of four."""

    node: Array  # (ROWS, M)
    dof: Array  # (DOF_ROWS, N + 1)
    at: Array  # (6,) k_hat, phi_hat, x_hat, y_hat and n_hat's components
    values: Array  # (M,) Legendre polynomials at s_hat
    integrals: Array  # (M,) of them up to there
    over: Array  # (2 M,) 1/(i + 1)
    by: Array  # (PLANES, M, P)
    matrix: Array  # (N + 1, P + 4 + N + 1) of Newton's method, bordered by J; then its inverse
    inverse: Array  # (N + 1, N + 1) a row for each residual


@jit
def new_work(M: int, N: int, P: int) -> Scratch:
    """Scratch arrays for M nodes and N coefficients."""
    over = np.empty(2 * M)
    for i in range(2 * M):
        over[i] = 1.0 / (i + 1)
    return Scratch(
        node=np.zeros((ROWS, M)), dof=np.zeros((DOF_ROWS, N + 1)), at=np.zeros(6),
        values=np.zeros(M), integrals=np.zeros(M), over=over,
        by=np.zeros((PLANES, M, P)), matrix=np.zeros((N + 1, P + 4 + N + 1)),
        inverse=np.zeros((N + 1, N + 1)),
    )  # fmt: skip
