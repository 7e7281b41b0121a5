"""Generalized-alpha steps, index 3, as Arnold & Bruels 2007 (Multibody Syst. Dyn. 18, 185).

q+ = q + h v + h^2 (1/2 - beta) a + h^2 beta a+,   v+ = v + h (1 - gamma) a + h gamma a+,
(1 - alpha_m) a+ + alpha_m a = (1 - alpha_f) q''+ + alpha_f q''; the equations of motion and
r(s_hat) = p_hat hold at the end of each step. Unknown: q+, N+ and s_hat+. The Prony series follows
by its exact recursion, with k a straight line in the step.
"""

# ruff: noqa: C901  (calls that numba does not inline cost more than they explain)
from __future__ import annotations

from typing import Any

import numpy as np

from model.dynamics.body import FAILED, SLIPPED
from model.dynamics.kernel.contact import levers, touch
from model.dynamics.kernel.residual import balance, move, pressed
from model.dynamics.kernel.tangent import assemble, edge, invert
from model.dynamics.kernel.work import (
    ALONG,
    FORMER,
    HISTORY,
    RHS,
    SLIDE,
    STEP,
    TURN_HAT,
    Scratch,
    new_work,
)
from model.jit import Array, jit, jit_inside

# An iteration takes at least this share of the error over: the first after a new matrix converges
# faster than the next ones will.
LEAST_RATE = 0.02
ROUNDING = 1e-12  # of the largest coefficient: nearer no iteration comes


@jit
def relax(h: float, body: Any, factors: Array) -> float:
    """Write e, a, b of each Prony term for a step; return 1 + sum g (1 - b)."""
    stiff = 1.0
    for i in range(len(body.shares)):
        x = h / body.times_s[i]
        gone = -np.expm1(-x)
        late = x * (0.5 - x * (1.0 / 6.0 - x / 24.0)) if x < 1e-3 else 1.0 - gone / x
        factors[i, 0], factors[i, 1], factors[i, 2] = 1.0 - gone, gone - late, late
        stiff += body.shares[i] * (1.0 - late)
    return stiff


@jit
def remember(body: Any, state: Any, factors: Array, dof: Array) -> None:
    """Write what the past adds to the Prony series' moment in this step."""
    for j in range(len(state.q)):
        dof[HISTORY, j] = 0.0
    for i in range(len(body.shares)):
        gone, early, share = factors[i, 0], factors[i, 1], body.shares[i]
        for j in range(len(state.q)):
            past = gone * state.z[i, j] + early * (state.q[j] - body.rest[j])
            state.z[i, j] = past  # the end of the step adds its share when it is known
            dof[HISTORY, j] += share * past


@jit
def relaxed(z: Array, q: Array, rest: Array, factors: Array) -> None:
    """Complete the internal variables with the end of the step."""
    for i in range(len(z)):
        late = factors[i, 2]
        for j in range(len(q)):
            z[i, j] += late * (q[j] - rest[j])


@jit_inside
def evaluate(
    body: Any, state: Any, moment: Array, clamp: Array, place: Array, contact: bool, stiff: float,
    w: Scratch,
) -> float:  # fmt: skip
    """Write the residuals' negative, the place along n_hat last; return what is along t_hat."""
    at, dof, size = w.at, w.dof, len(state.q)
    move(body.made, state.q, state.v, state.a, clamp, w.node)
    along = 0.0
    if contact:
        touch(body.made, clamp[0], state.x[1], state.q, w)
        gap_x, gap_y = place[0] - at[2], place[1] - at[3]
        dof[RHS, size] = at[4] * gap_x + at[5] * gap_y
        along = at[5] * gap_x - at[4] * gap_y
        pressed(state.x[0], at, w.node)
    balance(body.made.turn, w.node, dof)
    for j in range(size):
        bent = stiff * (state.q[j] - body.rest[j]) - dof[HISTORY, j] + body.viscous_s * state.v[j]
        dof[RHS, j] = moment[j] - body.stiffness[j] * bent - dof[RHS, j]
    return along


@jit
def predict(state: Any, h: float, of: Any, dof: Array) -> None:
    """Begin a step: q'' goes on in a straight line; FORMER keeps what it was at the last end."""
    over, early = 1.0 / (1.0 - of.alpha_m), h * h * (0.5 - of.beta)
    for j in range(len(state.q)):
        a, mean = state.a[j], state.a_mean[j]
        guess = 2.0 * a - dof[FORMER, j]
        dof[FORMER, j] = a
        new = ((1.0 - of.alpha_f) * guess + of.alpha_f * a - of.alpha_m * mean) * over
        state.q[j] += h * state.v[j] + early * mean + h * h * of.beta * new
        state.v[j] += h * ((1.0 - of.gamma) * mean + of.gamma * new)
        state.a[j], state.a_mean[j] = guess, new


@jit_inside
def renew(body: Any, state: Any, contact: bool, elastic: float, by: Array, w: Scratch) -> bool:
    """Write the inverse of Newton's matrix for the state just evaluated; by: dv/dq, da/dq."""
    if contact:
        levers(body.made.turn, w.at, w.node, w.dof)
    assemble(body.made, by, w)
    size = edge(elastic, body.stiffness, state.x[0], contact, w.dof, w.matrix)
    return invert(size, w.matrix, w.inverse)


@jit
def solve(order: int, inverse: Array, dof: Array) -> None:
    """Write STEP from RHS."""
    for i in range(order):
        dof[STEP, i] = 0.0
    for j in range(order):
        residual = dof[RHS, j]
        for i in range(order):
            dof[STEP, i] += inverse[j, i] * residual


@jit_inside
def correct(state: Any, contact: bool, along: float, by: Array, at: Array, dof: Array) -> float:
    """Make one iteration's step; return the largest change of a coefficient."""
    size = len(state.q)
    largest, turned = 0.0, 0.0
    for j in range(size):
        change = dof[STEP, j]
        largest = max(largest, abs(change))
        along -= dof[ALONG, j] * change
        turned += dof[TURN_HAT, j] * change
        state.q[j] += change
        state.v[j] += by[0] * change
        state.a[j] += by[1] * change
        state.a_mean[j] += by[2] * change
    if contact:
        state.x[0] += dof[STEP, size]
        state.x[1] += along
        state.x[2] = at[1] + turned + at[0] * along
    return largest


@jit
def nearness(q: Array, wanted: float) -> float:
    """Return the change of a coefficient below which an iteration may end."""
    largest = 0.0
    for j in range(len(q)):
        largest = max(largest, abs(q[j]))
    return max(wanted, ROUNDING * largest)


@jit
def write(n: int, state: Any, track: Any) -> None:
    """Write the state down at step n."""
    for j in range(len(state.q)):
        track.q[n, j], track.v[n, j] = state.q[j], state.v[j]
    for i in range(3):
        track.x[n, i] = state.x[i]


@jit
def march(body: Any, given: Any, state: Any, of: Any, track: Any) -> tuple[int, int]:
    """Move the state on through all steps; write it down.

    Returns the steps that were made, and 0, SLIPPED or FAILED.
    """
    size, contact = len(state.q), given.contact
    w = new_work(len(body.made.mass), size, body.made.angle.shape[1])
    dof, factors = w.dof, np.zeros((len(body.shares), 3))
    by, x_rate = np.zeros(3), np.zeros(2)
    h_old, age, rate, stiff = 0.0, 0, 0.0, 1.0
    write(0, state, track)
    for n in range(len(given.step_s)):
        h = given.step_s[n]
        if abs(h - h_old) > 1e-9 * h:
            h_old, age = h, of.keep
            stiff = relax(h, body, factors)
            by[0] = of.gamma / (h * of.beta)
            by[1] = (1.0 - of.alpha_m) / (h * h * of.beta * (1.0 - of.alpha_f))
            by[2] = 1.0 / (h * h * of.beta)
            for j in range(size):
                dof[FORMER, j] = state.a[j]
            x_rate[0] = x_rate[1] = 0.0
        remember(body, state, factors, dof)
        predict(state, h, of, dof)
        state.x[0] += x_rate[0]
        state.x[1] += x_rate[1]
        near, before, done = nearness(state.q, of.tolerance * h * h), 0.0, False
        for k in range(of.most):
            along = evaluate(
                body=body, state=state, moment=given.moment[n + 1], clamp=given.clamp[n + 1],
                place=given.place[n + 1], contact=contact, stiff=stiff, w=w,
            )  # fmt: skip
            if age >= of.keep or k >= 4:
                if not renew(body, state, contact, stiff + body.viscous_s * by[0], by, w):
                    return n, FAILED
                age, rate = 0, 0.0
            if contact:
                for j in range(size):
                    dof[RHS, j] -= state.x[0] * along * dof[SLIDE, j]
            solve(size + 1 if contact else size, w.inverse, dof)
            largest = correct(state, contact, along, by, w.at, dof)
            if not largest < 1e9:  # nor where it is not a number
                return n, FAILED
            if contact and not 0.0 < state.x[1] <= body.reach_m:
                return n, SLIPPED
            if k > 0:
                rate = min(max(largest / before, rate, LEAST_RATE), 1.0)
            before = largest
            if (rate if rate > 0.0 else 1.0) * largest < near:
                done = True
                break
        if not done:
            return n, FAILED
        age += 1
        relaxed(state.z, state.q, body.rest, factors)
        write(n + 1, state, track)
        for i in range(2):
            x_rate[i] = state.x[i] - track.x[n, i]
    return len(given.step_s), 0
