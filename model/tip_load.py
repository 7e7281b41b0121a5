"""The free-ended sheet with a force at its tip: of fixed direction, or turning with the tip.

Collocation as in `_twin.py`, backward from the tip in the tip's frame. With (t, n) the components
of the force on the sheet over B in that frame: k = k* + c (a n - b t), where a and b are the tip's
distance along and across. The load grows in steps, so that the shape is the one reached from rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from model.beam import finer
from model.field import Field, merged_breaks
from model.gauss import rule
from model.measurements import FloatArray, ModelError

NODES = 16
MOST_ITERATIONS = 30
TINY = 1e-40


@dataclass(frozen=True)
class TipLoaded:
    """The shape under a tip load; angles at the clamp are 0."""

    s_m: FloatArray  # nodes, descending from the tip, then the clamp
    x_m: FloatArray  # of the same points
    y_m: FloatArray
    tip_x_m: float
    tip_y_m: float
    tip_rad: float
    root_moment_per_m: float  # M(0)/B


def tip_load(
    kappa: Field,
    force_per_m2: tuple[float, float],
    follows: bool,
    softness: Field | None = None,
) -> TipLoaded:
    """Equilibrium under the force (x, y) over B on the tip.

    `follows`: the components stay those along and across the tip's direction.
    """
    size = float(np.hypot(*force_per_m2))
    if not np.isfinite(size):
        raise ModelError("a tip load must be finite")
    problem = _TipProblem(kappa, force_per_m2, follows, softness)
    steps = max(1, int(np.ceil(size * kappa.length_m**2 / 1.0)))
    u = problem.free()
    for step in range(steps):
        u = problem.newton(u, (step + 1) / steps)
    return problem.result(u)


class _TipProblem:
    """Residual of all nodes psi and of the tip's angle."""

    def __init__(
        self, kappa: Field, force: tuple[float, float], follows: bool, softness: Field | None
    ) -> None:
        every = [kappa.breaks_m] + ([softness.breaks_m] if softness else [])
        turn = kappa.largest + np.hypot(*force) * kappa.length_m
        breaks = finer(merged_breaks(every), turn, kappa.length_m)
        self.rule, self.h = rule(NODES), np.diff(breaks)[::-1]
        self.s = breaks[1:][::-1, None] - self.h[:, None] * self.rule.c
        length = kappa.length_m
        self.turn = kappa.integral(length) - kappa.integral(self.s)
        self.turned = float(kappa.integral(length))
        self.c = softness(self.s) if softness else np.ones_like(self.s)
        self.force, self.follows = force, follows

    def free(self) -> FloatArray:
        """The unknowns without load."""
        return np.append(-self.turn.ravel(), self.turned)

    def _integral(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """From the tip to each node, and to the clamp."""
        whole = self.h * (values @ self.rule.b)
        before = np.cumsum(whole, axis=-1) - whole
        inner = self.h[:, None] * (values @ self.rule.A.T)
        return inner + before[..., None], whole.sum(-1)

    def _residual(self, u: FloatArray, share: float) -> FloatArray:
        """For unknowns (..., nodes + 1), real or complex."""
        psi, tip = u[..., :-1].reshape(*u.shape[:-1], *self.s.shape), u[..., -1, None, None]
        along, across = self.force[0] * share, self.force[1] * share
        load: tuple[Any, Any] = (along, across)
        if not self.follows:
            cos, sin = np.cos(tip), np.sin(tip)
            load = (along * cos + across * sin, across * cos - along * sin)
        a, b = self._integral(np.cos(psi))[0], self._integral(np.sin(psi))[0]
        bent, all_bent = self._integral(self.c * (a * load[1] - b * load[0]))
        inner = psi + self.turn + bent
        end = u[..., -1] - self.turned - all_bent
        return np.concatenate([inner.reshape(*u.shape[:-1], -1), end[..., None]], axis=-1)

    def newton(self, u: FloatArray, share: float) -> FloatArray:
        """The equilibrium at a share of the load, from one nearby."""
        unit = 1j * TINY * np.eye(len(u))
        for _ in range(MOST_ITERATIONS):
            J = self._residual(u + unit, share).imag.T / TINY
            step = np.linalg.solve(J, -self._residual(u, share))
            size = float(np.max(np.abs(step)))
            u = u + step * min(1.0, 0.5 / max(size, 1e-12))
            if size < 1e-9:
                return u
        raise ModelError("no equilibrium was found under this tip load: it is too large")

    def result(self, u: FloatArray) -> TipLoaded:
        """The shape in the clamp's frame."""
        psi, tip = u[:-1].reshape(self.s.shape), float(u[-1])
        a, b = self._integral(np.cos(psi)), self._integral(np.sin(psi))
        cos, sin = np.cos(tip), np.sin(tip)
        forward, aside = (np.append(part.ravel(), end) for part, end in (a, b))
        tip_x = cos * forward[-1] - sin * aside[-1]
        tip_y = sin * forward[-1] + cos * aside[-1]
        fx, fy = self.force
        if self.follows:
            fx, fy = cos * fx - sin * fy, sin * fx + cos * fy
        return TipLoaded(
            np.append(self.s.ravel(), 0.0),
            tip_x - (cos * forward - sin * aside), tip_y - (sin * forward + cos * aside),
            float(tip_x), float(tip_y), tip, float(tip_x * fy - tip_y * fx),
        )  # fmt: skip
