"""Scratch arrays of one march."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from model.jit import Array, jit


class Scratch(NamedTuple):
    """At the M nodes where not said otherwise; x and y are rows 0 and 1."""

    phi: Array
    sin: Array
    cos: Array
    spin: Array  # phi_t
    swing: Array  # phi_tt
    e: Array  # (2, M) d/ds of r_tt, then of r_t
    acceleration: Array  # (2, M) r_tt
    velocity: Array  # (2, M) r_t
    force: Array  # (2, M) of inertia and fluid at the nodes
    cut: Array  # (2, M) its sum beyond a node, times the node's weight: the force in the cut
    hat: Array  # nodal values -> their integral up to s_hat
    turn_hat: Array  # (N,) coefficients -> phi_hat
    at: Array  # (6,) k_hat, phi_hat, x_hat, y_hat, and n_hat's components
    J: Array  # (N,) n_hat . dr_hat/dq
    T: Array  # (N,) t_hat . dr_hat/dq
    slide: Array  # (N,) how the contact's moment changes with s_hat, over N
    start: Array  # (2, N) at the start of a panel
    by: Array  # (6, M, N) dr/dq, dr_t/dq, dr_tt/dq: x, y of each
    push: Array  # (2, N) d(force)/dq at one node
    matrix: Array  # (N + 1, N + 1) of Newton's method, bordered by J
    inverse: Array  # (N + 1, N + 1)
    rhs: Array  # (N + 1,)
    step: Array  # (N + 1,)
    over: Array  # (2 M - 1,) 1/(i + 1)
    history: Array  # (N,) what the past adds to the Prony series


@jit
def new_work(M: int, N: int) -> Scratch:
    """Scratch arrays for M nodes and N coefficients."""
    return Scratch(
        phi=np.zeros(M), sin=np.zeros(M), cos=np.zeros(M), spin=np.zeros(M), swing=np.zeros(M),
        e=np.zeros((2, M)), over=1.0 / np.arange(1.0, 2.0 * M), history=np.zeros(N),
        acceleration=np.zeros((2, M)), velocity=np.zeros((2, M)), force=np.zeros((2, M)),
        cut=np.zeros((2, M)), hat=np.zeros(M), turn_hat=np.zeros(N), at=np.zeros(6), J=np.zeros(N),
        T=np.zeros(N), slide=np.zeros(N), start=np.zeros((2, N)), by=np.zeros((6, M, N)),
        push=np.zeros((2, N)), matrix=np.zeros((N + 1, N + 1)), inverse=np.zeros((N + 1, N + 1)),
        rhs=np.zeros(N + 1), step=np.zeros(N + 1),
    )  # fmt: skip
