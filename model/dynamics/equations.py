"""The equations of motion in NumPy, for batches of states, real or complex.

Written with whole matrices; derivatives are taken by complex step, so that none of the compiled
kernel's algebra is repeated. They find the static start, linearise, and are the reference that the
kernel is compared with.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from model.dynamics.body import Body
from model.dynamics.space import Space, dense
from model.mechanics.collocation import integrated_legendre

Numbers = np.ndarray[Any, Any]  # real, or complex where derivatives are taken
TINY = 1e-40  # of a complex step
MOST_STEPS = 40


class Motions(NamedTuple):
    """A batch of C states."""

    q: Numbers  # (C, N)
    v: Numbers
    a: Numbers
    N: Numbers  # (C,)
    s_hat: Numbers  # (C,)


def moments(body: Body, at: Motions, clamp: Numbers, contact: bool) -> tuple[Numbers, Numbers]:
    """Return the moments of inertia, fluid and contact (C, N), and r(s_hat) (C, 2).

    clamp: psi and its derivatives in time, (3,).
    """
    angle, position = dense(body.space)
    phi, spin, swing = (x @ angle.T + c for x, c in zip((at.q, at.v, at.a), clamp, strict=True))
    cos, sin = np.cos(phi), np.sin(phi)
    ax, ay = (-sin * swing - cos * spin**2) @ position.T, (cos * swing - sin * spin**2) @ position.T
    vx, vy = (-sin * spin) @ position.T, (cos * spin) @ position.T
    across, along = -sin * vx + cos * vy, cos * vx + sin * vy
    drag = body.normal + body.quadratic * np.where(across.real < 0.0, -across, across)
    normal = body.added * (-sin * ax + cos * ay) + drag * across
    fx = body.mass * ax - sin * normal + cos * body.tangential * along
    fy = body.mass * ay + cos * normal + sin * body.tangential * along
    cut_x, cut_y = fx @ position, fy @ position
    ends = np.zeros((len(at.q), 2))
    if contact:
        turn, run = at_contact(body.space, at.s_hat)
        phi_hat = (turn * at.q).sum(1) + clamp[0]
        ends = np.stack([(run * cos).sum(1), (run * sin).sum(1)], axis=1)
        push = at.N[:, None] * run
        cut_x = cut_x - push * np.sin(phi_hat)[:, None]
        cut_y = cut_y + push * np.cos(phi_hat)[:, None]
    return (-sin * cut_x + cos * cut_y) @ angle, ends


def at_contact(on: Space, s_hat: Numbers) -> tuple[Numbers, Numbers]:
    """Return rows (C, N) and (C, M): coefficients -> phi_hat, nodal values -> integral."""
    turn = np.zeros((len(s_hat), on.size), dtype=s_hat.dtype)
    run = np.zeros((len(s_hat), len(on.s_m)), dtype=s_hat.dtype)
    last = len(on.breaks_m) - 3 if on.breaks_m[-2] > on.breaks_m[-3] else len(on.breaks_m) - 4
    panel = np.minimum(np.searchsorted(on.breaks_m[1:-1], s_hat.real, side="right"), last)
    for p in range(last + 1):
        nodes = slice(on.first_node[p], on.first_node[p + 1])
        dofs = slice(on.first_dof[p], on.first_dof[p + 1])
        h, n = on.breaks_m[p + 1] - on.breaks_m[p], nodes.stop - nodes.start
        t = np.where(panel > p, 1.0, 2.0 * (s_hat - on.breaks_m[p]) / h - 1.0)
        t = np.where(panel < p, -1.0, t)
        integrals = 0.5 * h * _integrated(t, n)
        run[:, nodes] = integrals @ on.to_legendre[nodes, :n]
        turn[:, dofs] = integrals[:, : dofs.stop - dofs.start]
    return turn, run


def _integrated(t: Numbers, count: int) -> Numbers:
    """Integrals of Legendre polynomials from -1 to t, complex where t is."""
    value = integrated_legendre(t.real, count)
    if not np.iscomplexobj(t):
        return value
    slope = np.polynomial.legendre.legvander(t.real, count - 1)
    return np.asarray(value + 1j * t.imag[:, None] * slope)


def static_residual(
    body: Body, u: Numbers, moment: Numbers, clamp: Numbers, place: Numbers, contact: bool
) -> Numbers:
    """Return the equations at rest (C, N + 2), or (C, N) without contact, for u = (q, N, s_hat)."""
    size = body.space.size
    zero = np.zeros_like(u[:, :size])
    touch = (u[:, size], u[:, size + 1]) if contact else (u[:, 0], u[:, 0])
    at = Motions(u[:, :size], zero, zero, *touch)
    turned, ends = moments(body, at, np.array([clamp[0], 0.0, 0.0]), contact)
    bent = turned + body.stiffness * (at.q - body.rest) - moment
    return np.concatenate([bent, ends - place], axis=1) if contact else bent


def derivative(function: Any, u: Numbers) -> Numbers:
    """Return d f_i / d u_k of a batched function at one u (n,), by complex step."""
    steps = u.astype(complex) + 1j * TINY * np.eye(len(u))
    return np.asarray(function(steps).imag.T / TINY)


def newton(function: Any, u: Numbers, scale: Numbers, small: float) -> Numbers | None:
    """Solve f(u) = 0 from u; None: no convergence.

    It ends with steps below `small` times `scale`, or below a thousand times that when they no
    longer shrink: then rounding is what is left.
    """
    before = np.inf
    for _ in range(MOST_STEPS):
        change = np.linalg.solve(derivative(function, u), -function(u[None])[0])
        u = u + change
        size = float(np.max(np.abs(change) / scale))
        if size < small or (size < 1e3 * small and size > 0.3 * before):
            return u
        if not size < 1e9:
            break
        before = size
    return None
