"""After Gonzalez and Llorca 2005: a curved elastic strip at large displacement, static.

    B (k - k0) = M, without stretching; along the chord: B (k - k0) = -P y, P the axial force
The strip does not know of voltage: in a session it predicts the passive force in contact and the
shape at rest, whatever the drive. `chord_m` is the source's own case, an axial load.

Own reading: the strip is held and pressed as the paper's sheet is; k0 plus one uniform curvature.
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
from model.measurements import FloatArray, ModelError
from model.mechanics.equilibrium import SolverStatus, problems, solve
from model.mechanics.field import Field
from model.mechanics.free_shape import free_shape

CHORD_STEPS = 400  # of half a strip


@dataclass(frozen=True, kw_only=True)
class Gonzalez(PublishedModel):
    """See the module."""

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """See `PublishedModel.simulate`."""
        sheet, length = run.sheet, run.sheet.free_length_m
        rest = run.rest + Field.constant(p["bend_per_m"], length)
        s = np.linspace(0.0, length, PLACES)
        n, frames = len(run.time_s), len(run.frames)
        if run.free:
            x, y, _ = free_shape(rest, s)
            return Response(tip_m=np.full(n, y[-1]), curves_m=_repeated(x, y, frames))
        found = solve(problems(rest, run.angle_rad, sheet.arc_radius_m, sheet.elongation_m))
        if found.status[0] != SolverStatus.SOLVED:
            raise ModelError("the strip has no equilibrium at this position")
        shape = found.shapes(s)
        return Response(
            force_N=np.full(n, float(found.force(p["B_Nm2"])[0])),
            tip_m=np.full(n, shape.y_m[0, -1]),
            curves_m=_repeated(shape.x_m[0], shape.y_m[0], frames),
        )


def _repeated(x: FloatArray, y: FloatArray, frames: int) -> tuple[FloatArray, FloatArray]:
    return np.tile(x, (frames, 1)), np.tile(y, (frames, 1))


def chord_m(force_over_B: float, k0_per_m: float, length_m: float) -> float:
    """Return the chord of a strip of uniform k0 whose ends are pulled apart by P = B force_over_B.

    From the middle on, theta' = k, k' = (P/B) sin(theta), and k = k0 at the end (RK4, shooting).
    Shorter of the two solutions in k at the middle; `ModelError` where the strip buckles.
    """
    from scipy.optimize import brentq  # slow to import

    h = 0.5 * length_m / CHORD_STEPS

    def slope(theta: float, k: float) -> FloatArray:
        return np.array([k, force_over_B * np.sin(theta), np.cos(theta)])

    def end(k_middle: float) -> FloatArray:
        at = np.array([0.0, k_middle, 0.0])
        for _ in range(CHORD_STEPS):
            one = slope(at[0], at[1])
            two = slope(*(at + 0.5 * h * one)[:2])
            three = slope(*(at + 0.5 * h * two)[:2])
            at = at + h / 6.0 * (one + 2.0 * two + 2.0 * three + slope(*(at + h * three)[:2]))
        return at

    low, high = sorted((0.0, 2.0 * k0_per_m))
    if (end(low)[1] - k0_per_m) * (end(high)[1] - k0_per_m) > 0.0:
        raise ModelError("the strip does not carry this axial force")
    middle = brentq(lambda k: end(k)[1] - k0_per_m, low, high, xtol=1e-13)
    return 2.0 * float(end(middle)[2])


MODEL = Gonzalez(
    name="gonzalez",
    title="after González and Llorca 2005, static",
    from_source=False,
    source="Int. J. Solids Struct. 42, 1537-45 (not read)",
    equations="B (k - k0) = M, large displacement; axial load: M = -P y",
    own_reading="the load of the paper's sheet; one uniform curvature added to k0",
    states=(),
    parameters=(
        ModelParameter(
            name="B_Nm2", meaning="bending stiffness", unit="N m2", start=1e-6, low=1e-9, high=1e-3
        ),
        ModelParameter(
            name="bend_per_m", meaning="uniform curvature beside k0", unit="1/m",
            start=0.0, low=-50.0, high=50.0, prior_scale=2.0,
        ),
    ),
    predicts_in_contact=frozenset({"force", "tip", "curve"}),
    predicts_free=frozenset({"tip", "curve"}),
)  # fmt: skip
