"""The sheet of a run as a linear beam, kappa = Me/B the same all along it.

See `model.mechanics.linear_beam`.
"""

from __future__ import annotations

import numpy as np

from model.dynamics.models.contract import PLACES, DrivenSheet, Response
from model.measurements import FloatArray, ModelError
from model.mechanics.field import Field
from model.mechanics.linear_beam import LinearBeam


def small_deflection(run: DrivenSheet) -> LinearBeam:
    """Return the beam of a run; `ModelError` where it does not reach the load cell."""
    uniform = Field.constant(1.0, run.sheet.free_length_m)
    if run.free:
        return LinearBeam(run.rest, uniform)
    sheet = run.sheet
    if sheet.arc_radius_m > sheet.free_length_m + sheet.elongation_m:
        raise ModelError("the sheet and its elongation do not reach the load cell")
    return LinearBeam(run.rest, uniform, sheet.arc_radius_m, run.angle_rad)


def beam_response(
    run: DrivenSheet, B_Nm2: float, kappa_per_m: FloatArray, current_A: FloatArray | None = None
) -> Response:
    """Return force, tip and curves for curvatures Me/B (n,), without inertia."""
    beam, length = small_deflection(run), run.sheet.free_length_m
    x = np.linspace(0.0, length, PLACES)
    y = beam.heights_m(x, kappa_per_m[run.frames])
    return Response(
        force_N=None if run.free else B_Nm2 * beam.force_over_B(kappa_per_m),
        current_A=current_A,
        tip_m=beam.heights_m(np.array([length]), kappa_per_m)[:, 0],
        curves_m=(np.broadcast_to(x, y.shape), y),
    )
