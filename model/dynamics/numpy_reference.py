"""The motion in NumPy: the same scheme as the compiled kernel, on `equations`.

Every step is solved by Newton's method to rounding, with derivatives by complex step. It checks the
kernel and stands in for it where numba is missing; it is some hundred times slower.
"""

from __future__ import annotations

import numpy as np

from model.dynamics.body import FAILED, SLIPPED, Body, Given, MotionState, Scheme, StepHistory
from model.dynamics.equations import Motions, Numbers, at_contact, moments, newton
from model.dynamics.material import relaxation

SMALL = 1e-11  # a step of Newton's method that ends it


def march(
    body: Body, given: Given, state: MotionState, of: Scheme, track: StepHistory
) -> tuple[int, int]:
    """As the kernel's `march`."""
    track.q[0], track.v[0], track.x[0] = state.q, state.v, state.x
    for n, h in enumerate(given.step_s):
        try:
            done = _step(body, given, state, of, n, float(h))
        except np.linalg.LinAlgError:
            done = False
        if not done:
            return n, FAILED
        if given.contact and not 0.0 < state.x[1] <= body.reach_m:
            return n, SLIPPED
        track.q[n + 1], track.v[n + 1], track.x[n + 1] = state.q, state.v, state.x
    return len(given.step_s), 0


def _step(body: Body, given: Given, state: MotionState, of: Scheme, n: int, h: float) -> bool:
    """Make step n; False where Newton's method does not converge."""
    size, contact = body.space.size, given.contact
    e, early, late = (f[:, None] for f in relaxation(h, body.times_s))
    g = body.shares[:, None]
    past = e * state.z + early * (state.q - body.rest)

    def end(q: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """Return v, q'' and the scheme's acceleration at the end, from q there."""
        mean = (q - state.q - h * state.v) / h**2 - (0.5 - of.beta) * state.a_mean
        mean = mean / of.beta
        v = state.v + h * (1.0 - of.gamma) * state.a_mean + h * of.gamma * mean
        a = (1.0 - of.alpha_m) * mean + of.alpha_m * state.a_mean - of.alpha_f * state.a
        return v, a / (1.0 - of.alpha_f), mean

    def residual(u: Numbers) -> Numbers:
        q = u[:, :size]
        v, a, _ = end(q)
        touch = (u[:, size], u[:, size + 1]) if contact else (u[:, 0], u[:, 0])
        turned, ends = moments(body, Motions(q, v, a, *touch), given.clamp[n + 1], contact)
        y = q - body.rest
        z = past[:, None] + late[:, None] * y  # (I, C, N)
        bent = y + body.viscous_s * v + (g[:, None] * (y - z)).sum(0)
        R = turned + body.stiffness * bent - given.moment[n + 1]
        return np.concatenate([R, ends - given.place[n + 1]], axis=1) if contact else R

    scale = np.concatenate([np.full(size, 1.0 / body.space.length_m), [1.0, body.space.length_m]])
    scale[size] = body.stiffness[0] * scale[0] ** 3  # B/l^2, about
    u = np.concatenate([state.q, state.x[:2]]) if contact else state.q.copy()
    found = newton(residual, u, scale[: len(u)], SMALL)
    if found is None:
        return False
    v, a, mean = end(found[:size])
    state.z[:] = past + late * (found[:size] - body.rest)
    state.q[:], state.v[:], state.a[:], state.a_mean[:] = found[:size], v, a, mean
    if contact:
        turn, _ = at_contact(body.space, found[size + 1 :])
        state.x[:2] = found[size:]
        state.x[2] = turn[0] @ state.q + given.clamp[n + 1, 0]
    return True
