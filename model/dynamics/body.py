"""What the solvers of motion work on, compiled or not: arrays of the body, its drive, its state."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from model.dynamics.space import Space
from model.measurements import FloatArray

SLIPPED, FAILED = 1, 2  # how a march may end early


class Packed(NamedTuple):
    """The body as the compiled kernel reads it: M nodes, N coefficients, P: N in whole fours.

    Nodes that hold nothing are left out; M is a multiple of four, with nodes of no mass at the end.
    """

    turn: FloatArray  # (N, M) coefficients -> angle at the nodes
    angle: FloatArray  # (M, P) the same
    run: FloatArray  # (M, M) values at the nodes (rows) -> their integrals to the nodes
    back: FloatArray  # (M, M) its transpose
    mass: FloatArray  # (M,)
    fluid: FloatArray  # (4, M) added mass, normal, quadratic and tangential drag
    wet: bool  # one of these is not zero
    weight_m: FloatArray  # (M,)
    to_legendre: FloatArray  # (M, n) as of the space
    breaks_m: FloatArray  # as of the space
    flexible: int
    first_node: np.ndarray[tuple[int], np.dtype[np.int64]]
    first_dof: np.ndarray[tuple[int], np.dtype[np.int64]]


class Body(NamedTuple):
    """The sheet and its elongation in a space of M nodes and N coefficients."""

    space: Space
    angle: FloatArray  # (M, N) coefficients -> angle at the nodes, whole
    mass: FloatArray  # (M,) kg at the nodes
    added: FloatArray  # (M,) fluid's coefficients times the nodes' weights
    normal: FloatArray
    quadratic: FloatArray
    tangential: FloatArray
    wet: bool  # one of the four is not zero
    stiffness: FloatArray  # (N,) B int P_j^2
    rest: FloatArray  # (N,) coefficients of k0
    viscous_s: float
    shares: FloatArray  # (I,)
    times_s: FloatArray  # (I,)
    reach_m: float  # where sheet or elongation ends
    made: Packed


class Given(NamedTuple):
    """What is prescribed at the ends of n steps."""

    step_s: FloatArray  # (n,)
    moment: FloatArray  # (n + 1, N) int Me P_j ds
    clamp: FloatArray  # (n + 1, 3) psi and its two derivatives in time
    place: FloatArray  # (n + 1, 2) p_hat
    contact: bool


class MotionState(NamedTuple):
    """What goes on from one step to the next; changed in place."""

    q: FloatArray  # (N,)
    v: FloatArray  # (N,) dq/dt
    a: FloatArray  # (N,) d2q/dt2
    a_mean: FloatArray  # (N,) generalized-alpha's own acceleration
    z: FloatArray  # (I, N) internal variables of the Prony series
    x: FloatArray  # (3,) N, s_hat and phi_hat


class Scheme(NamedTuple):
    """Numbers of generalized-alpha (Arnold & Bruels 2007, index 3) for a step h and a rho_inf."""

    alpha_m: float
    alpha_f: float
    gamma: float
    beta: float
    tolerance: float  # of d2q/dt2, 1/(m s^2)
    keep: int  # steps that share a matrix
    most: int  # iterations


def scheme(rho: float, tolerance: float, keep: int = 25, most: int = 30) -> Scheme:
    """Return the numbers for a spectral radius rho at infinite frequency."""
    alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    return Scheme(alpha_m, alpha_f, gamma, beta, tolerance, keep, most)


class StepHistory(NamedTuple):
    """What a march writes down: the state at the ends of its steps."""

    q: FloatArray  # (n + 1, N)
    v: FloatArray
    x: FloatArray  # (n + 1, 3) N, s_hat and phi_hat


def new_history(given: Given, size: int) -> StepHistory:
    """Return a track full of NaN."""
    n = len(given.step_s) + 1
    every = np.empty(n * (2 * size + 3))
    every.fill(np.nan)
    q, v, x = every[: n * size], every[n * size : 2 * n * size], every[2 * n * size :]
    return StepHistory(q.reshape(n, size), v.reshape(n, size), x.reshape(n, 3))
