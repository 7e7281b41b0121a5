"""A sheet whose curvature is the same all along it, free or against the load cell.

In contact the arc passes through the rolls, or its straight elongation does, so that its curvature
is known; the moments balance in the mean along the loaded part: B (k0 + kappa - k) = N lever.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.dynamics.models.contract import DrivenSheet
from model.dynamics.models.small_deflection import PLACES, mean_rest_curvature
from model.measurements import FloatArray, ModelError

GAUSS = np.polynomial.legendre.leggauss(30)


def arc_points(k: FloatArray, s_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return x, y (n, s) of arcs of curvatures k (n,) that leave the clamp along x."""
    half = 0.5 * np.outer(k, s_m)
    chord = s_m * np.sinc(half / np.pi)
    return chord * np.cos(half), chord * np.sin(half)


@dataclass(frozen=True)
class ContactArc:
    """The arc through a contact."""

    curvature_per_m: float
    mean_rest_per_m: float  # k0 of the loaded part
    lever_m: float  # mean lever of the normal force along the loaded part
    cosine: float  # F/N

    def force_over_B(self, kappa_per_m: FloatArray) -> FloatArray:
        """Return F/B for curvatures Me/B, (n,)."""
        push = (self.mean_rest_per_m + kappa_per_m - self.curvature_per_m) / self.lever_m
        return np.asarray(push * self.cosine)


def contact_arc(run: DrivenSheet) -> ContactArc:
    """Return the arc of a run in contact; `ModelError` where it does not reach the load cell."""
    angle, R, length = run.angle_rad, run.sheet.arc_radius_m, run.sheet.free_length_m
    k = 2.0 * np.sin(angle) / R
    loaded = 2.0 * angle / k if abs(k) > 1e-9 else R
    if loaded > length:
        k, loaded = _with_elongation(run), length
    s, w = GAUSS
    x, y = arc_points(np.array([k]), 0.5 * loaded * (1.0 + s))
    phi = k * loaded
    lever = (R * np.cos(angle) - x[0]) * np.cos(phi) + (R * np.sin(angle) - y[0]) * np.sin(phi)
    return ContactArc(
        float(k), mean_rest_curvature(run.sheet, loaded), float(0.5 * w @ lever),
        float(np.cos(phi - angle)),
    )  # fmt: skip


def _with_elongation(run: DrivenSheet) -> float:
    """Return the curvature at which the straight line beyond the sheet meets the rolls."""
    from scipy.optimize import brentq  # slow to import

    angle, R, length = run.angle_rad, run.sheet.arc_radius_m, run.sheet.free_length_m
    target = R * np.cos(angle), R * np.sin(angle)

    def aside(k: float) -> float:
        x, y = arc_points(np.array([k]), np.array([length]))
        phi = k * length
        return float(-(target[0] - x[0, 0]) * np.sin(phi) + (target[1] - y[0, 0]) * np.cos(phi))

    bend = 2.0 * angle / length + np.sign(angle) / length
    low, high = sorted((-0.1 * bend - 1e-3, bend + 1e-3))
    if aside(low) * aside(high) > 0.0:
        raise ModelError("an arc with a straight elongation does not reach the load cell")
    k = float(brentq(aside, low, high, xtol=1e-13))
    x, y = arc_points(np.array([k]), np.array([length]))
    if np.hypot(target[0] - x[0, 0], target[1] - y[0, 0]) > run.sheet.elongation_m:
        raise ModelError("the sheet and its elongation do not reach the load cell")
    return k


def arc_curves(run: DrivenSheet, k: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the curves of the run's frames; k (n,) of all samples."""
    return arc_points(k[run.frames], np.linspace(0.0, run.sheet.free_length_m, PLACES))


def arc_tip_m(run: DrivenSheet, k: FloatArray) -> FloatArray:
    """Return the height of the end of arcs, (n,)."""
    return arc_points(k, np.array([run.sheet.free_length_m]))[1][:, 0]
