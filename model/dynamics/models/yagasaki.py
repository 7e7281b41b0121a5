"""After Yagasaki and Tamagawa 2004: a linear viscoelastic beam with mass, free.

    mu y_tt + B*(p) y'''' = 0,  y = y' = 0 at 0;  B* y'' = Me, y''' = 0 at l
    B*(p) = B (1 + g p tau/(1 + p tau))                                  (standard linear solid)
with a uniform moment Me(t) = alpha U. Four modes move; higher ones follow without inertia. A free
shape tells B/mu (m4/s2) and alpha/B (1/(V m)), not B.

Own reading: tau_c U' = V - U; four modes; k0 is added. No force: the source's sheet is free.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model.dynamics.models.contract import (
    PLACES,
    DrivenSheet,
    ModelParameter,
    PublishedModel,
    Response,
)
from model.dynamics.models.held_drive import held_states
from model.measurements import FloatArray
from model.mechanics.linear_beam import heights_m

ROOTS = np.array([1.8751040687119612, 4.694091132974175, 7.854757438237613, 10.995540734875467])


def mode_shapes(x_over_l: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the cantilever's modes (4, x), of mean square 1, and l times their slope at l (4,)."""

    def shapes(at: FloatArray, odd: int) -> FloatArray:
        b = ROOTS[:, None] * at
        sigma = (np.cosh(ROOTS) + np.cos(ROOTS)) / (np.sinh(ROOTS) + np.sin(ROOTS))
        even = np.cosh(b) - np.cos(b), np.sinh(b) - np.sin(b)
        slope = np.sinh(b) + np.sin(b), np.cosh(b) - np.cos(b)
        first, second = slope if odd else even
        return np.asarray(first - sigma[:, None] * second)

    return shapes(x_over_l, 0), ROOTS * shapes(np.ones(1), 1)[:, 0]


@dataclass(frozen=True, kw_only=True)
class Yagasaki(PublishedModel):
    """See the module."""

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """See `PublishedModel.simulate`."""
        if not run.free:
            return Response()
        length = run.sheet.free_length_m
        A, B, moved = _system(p, length)
        states = held_states(A, B, run.time_s, run.drive_V)
        x = np.linspace(0.0, length, PLACES)
        shapes, slopes = mode_shapes(x / length)
        static = slopes / ROOTS**4 * length**2
        # U and z of what the higher modes add to the parabola of a uniform moment
        rest = (0.5 * x**2 - static @ shapes) / (1.0 + p["share"])
        by_state = np.zeros((len(B), PLACES))
        by_state[moved] = shapes
        by_state[0], by_state[1] = p["bend_per_Vm"] * rest, p["share"] * rest
        at_rest = heights_m(run.rest, x)
        y = at_rest + states[run.frames] @ by_state
        tip = at_rest[-1] + states @ by_state[:, -1]
        return Response(tip_m=tip, curves_m=(np.broadcast_to(x, y.shape), y))


def _system(p: Mapping[str, float], length_m: float) -> tuple[FloatArray, FloatArray, list[int]]:
    """Return A, B of U, z of the remainder, and (q, q', z) of each mode; the places of the q."""
    g, tau, bend = p["share"], p["relaxation_s"], p["bend_per_Vm"]
    n = 2 + 3 * len(ROOTS)
    A, B = np.zeros((n, n)), np.zeros(n)
    A[0, 0], B[0] = -1.0 / p["charging_s"], 1.0 / p["charging_s"]
    A[1, 0], A[1, 1] = bend / (tau * (1.0 + g)), -1.0 / (tau * (1.0 + g))
    stiffness = p["B_over_mu_m4_per_s2"] * (ROOTS / length_m) ** 4
    load = p["B_over_mu_m4_per_s2"] * bend * mode_shapes(np.ones(1))[1] / length_m**2
    for i in range(len(ROOTS)):
        q, v, z = 2 + 3 * i, 3 + 3 * i, 4 + 3 * i
        A[q, v] = 1.0
        A[v, 0], A[v, q], A[v, z] = load[i], -stiffness[i] * (1.0 + g), stiffness[i] * g
        A[z, q], A[z, z] = 1.0 / tau, -1.0 / tau
    return A, B, [2 + 3 * i for i in range(len(ROOTS))]


MODEL = Yagasaki(
    name="yagasaki",
    title="after Yagasaki and Tamagawa 2004",
    from_source=False,
    source="Physical Review E 70, 052801 (abstract read)",
    equations="mu y_tt + B*(p) y'''' = 0; B* = B (1 + g p tau/(1 + p tau)); uniform Me = alpha U",
    own_reading="U lags behind V; four modes, the others without inertia; k0 added",
    states=("U (V)", "z (1/m)", "q, q', z of each of four modes (m, m/s, m)"),
    parameters=(
        ModelParameter(
            name="B_over_mu_m4_per_s2", meaning="stiffness over mass per length", unit="m4/s2",
            start=2e-4, low=1e-7, high=1.0,
        ),
        ModelParameter(
            name="share", meaning="g, share of the stiffness that relaxes", unit="1",
            start=0.2, low=1e-3, high=10.0,
        ),
        ModelParameter(
            name="relaxation_s", meaning="tau of the relaxation", unit="s",
            start=0.05, low=1e-4, high=10.0,
        ),
        ModelParameter(
            name="bend_per_Vm", meaning="alpha/B, curvature per volt", unit="1/(V m)",
            start=30.0, low=-1e3, high=1e3, prior_scale=50.0,
        ),
        ModelParameter(
            name="charging_s", meaning="time of charging", unit="s", start=0.1, low=1e-3, high=10.0
        ),
    ),
    predicts_in_contact=frozenset(),
    predicts_free=frozenset({"tip", "curve"}),
)  # fmt: skip
