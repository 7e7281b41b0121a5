"""A sheet whose curvature is the same all along it, in a run: see `model.mechanics.arc`."""

from __future__ import annotations

import numpy as np

from model.dynamics.models.contract import PLACES, DrivenSheet
from model.measurements import FloatArray
from model.mechanics.arc import ArcContact, arc_contact, arc_points


def contact_arc(run: DrivenSheet) -> ArcContact:
    """Return the arc of a run in contact; `ModelError` where it does not reach the load cell."""
    sheet = run.sheet
    return arc_contact(run.rest, sheet.arc_radius_m, run.angle_rad, sheet.elongation_m)


def arc_curves(run: DrivenSheet, k: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the curves of the run's frames; k (n,) of all samples."""
    return arc_points(k[run.frames], np.linspace(0.0, run.sheet.free_length_m, PLACES))


def arc_tip_m(run: DrivenSheet, k: FloatArray) -> FloatArray:
    """Return the height of the end of arcs, (n,)."""
    return arc_points(k, np.array([run.sheet.free_length_m]))[1][:, 0]
