"""Where the energy of a motion is and where it went: work = stored + lost, a check of the steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.dynamics.body import Body, Given, StepHistory
from model.dynamics.material import relaxation
from model.dynamics.motion import Simulation
from model.dynamics.space import dense
from model.measurements import FloatArray


@dataclass(frozen=True, kw_only=True)
class Energy:
    """At the ends of the steps of a motion's first piece, in J, (n + 1,)."""

    kinetic: FloatArray
    elastic: FloatArray  # with what the Prony series holds
    lost: FloatArray  # in the material and the fluid since the piece began
    work: FloatArray  # of the moment Me since then

    @property
    def imbalance(self) -> FloatArray:
        """Return stored + lost - work, less its first value: 0 but for the error of the steps."""
        total = self.kinetic + self.elastic + self.lost - self.work
        return np.asarray(total - total[0])


def energy(of: Simulation) -> Energy:
    """Return the energies of a motion's first piece. The rolls must rest, and the clamp."""
    if of.made is None:
        raise ValueError("the simulation has not advanced yet")
    body, given, track = of.body, of.made.given, of.made.track
    K, y = body.stiffness, track.q - body.rest
    z = _internal(body, given, track)
    held = y[None] - z  # (I, n + 1, N)
    elastic = 0.5 * (K * y**2).sum(1)
    lost = _sum(given.step_s, body.viscous_s * (K * track.v**2).sum(1))
    for i, (g, tau) in enumerate(zip(body.shares, body.times_s, strict=True)):
        elastic = elastic + 0.5 * g * (K * held[i] ** 2).sum(1)
        lost = lost + _sum(given.step_s, g / tau * (K * held[i] ** 2).sum(1))
    kinetic, drag = _motion(body, track)
    middle = 0.5 * (given.moment[1:] + given.moment[:-1])
    work = np.concatenate([[0.0], np.cumsum((middle * np.diff(track.q, axis=0)).sum(1))])
    return Energy(kinetic=kinetic, elastic=elastic, lost=lost + _sum(given.step_s, drag), work=work)


def _sum(step_s: FloatArray, power: FloatArray) -> FloatArray:
    """Return the integral of a power over time, by trapezia."""
    return np.concatenate([[0.0], np.cumsum(0.5 * step_s * (power[1:] + power[:-1]))])


def _internal(body: Body, given: Given, track: StepHistory) -> FloatArray:
    """Return the internal variables (I, n + 1, N); they are relaxed where the piece begins."""
    y = track.q - body.rest
    z = np.repeat(y[None], len(body.shares), axis=0)
    for n, h in enumerate(given.step_s):
        e, early, late = (f[:, None] for f in relaxation(h, body.times_s))
        z[:, n + 1] = e * z[:, n] + early * y[n] + late * y[n + 1]
    return z


def _motion(body: Body, track: StepHistory) -> tuple[FloatArray, FloatArray]:
    """Return kinetic energy and the power lost in the fluid, (n + 1,) each."""
    angle, position = dense(body.space)
    phi, spin = track.q @ angle.T, track.v @ angle.T
    cos, sin = np.cos(phi), np.sin(phi)
    vx, vy = (-sin * spin) @ position.T, (cos * spin) @ position.T
    across, along = -sin * vx + cos * vy, cos * vx + sin * vy
    kinetic = 0.5 * (body.mass * (vx**2 + vy**2) + body.added * across**2).sum(1)
    drag = (body.normal + body.quadratic * np.abs(across)) * across**2
    return kinetic, (drag + body.tangential * along**2).sum(1)
