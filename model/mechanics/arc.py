"""A sheet whose curvature is the same all along it, against the rolls of the load cell.

The arc passes through the rolls, or its straight elongation does, so that its curvature is known;
the moments balance in the mean along the loaded part: B (k0 + kappa - k) = N lever.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.measurements import FloatArray, ModelError
from model.mechanics.field import Field

GAUSS = np.polynomial.legendre.leggauss(30)


def arc_points(k_per_m: FloatArray, s_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return x, y (n, s) of arcs of curvatures k (n,) that leave the clamp along x."""
    half = 0.5 * np.outer(k_per_m, s_m)
    chord = s_m * np.sinc(half / np.pi)
    return chord * np.cos(half), chord * np.sin(half)


@dataclass(frozen=True)
class ArcContact:
    """The arc through a contact."""

    curvature_per_m: float
    mean_rest_per_m: float  # k0 of the loaded part
    lever_m: float  # mean lever of the normal force along the loaded part
    cosine: float  # F/N

    def force_over_B(self, kappa_per_m: FloatArray) -> FloatArray:
        """Return F/B for curvatures Me/B, (n,)."""
        push = (self.mean_rest_per_m + kappa_per_m - self.curvature_per_m) / self.lever_m
        return np.asarray(push * self.cosine)


def arc_contact(rest: Field, radius_m: float, angle_rad: float, elongation_m: float) -> ArcContact:
    """Return the arc through the rolls; `ModelError` where it does not reach them."""
    R, length = radius_m, rest.length_m
    k = 2.0 * np.sin(angle_rad) / R
    loaded = 2.0 * angle_rad / k if abs(k) > 1e-9 else R
    if loaded > length:
        k, loaded = _with_elongation(length, R, angle_rad, elongation_m), length
    s, w = GAUSS
    x, y = arc_points(np.array([k]), 0.5 * loaded * (1.0 + s))
    phi = k * loaded
    at_x, at_y = R * np.cos(angle_rad), R * np.sin(angle_rad)
    lever = (at_x - x[0]) * np.cos(phi) + (at_y - y[0]) * np.sin(phi)
    return ArcContact(
        float(k), rest.mean(loaded), float(0.5 * w @ lever), float(np.cos(phi - angle_rad))
    )


def _with_elongation(length: float, R: float, angle: float, elongation_m: float) -> float:
    """Return the curvature at which the straight line beyond the sheet meets the rolls."""
    from scipy.optimize import brentq  # slow to import

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
    if np.hypot(target[0] - x[0, 0], target[1] - y[0, 0]) > elongation_m:
        raise ModelError("the sheet and its elongation do not reach the load cell")
    return k
