"""A measured curve as a smooth one: its curvature, angle, and where it meets the arc.

The curvature is a polynomial over the free length (0 on the elongation), and the squared distance
of the points along the normal is minimised under a small penalty on dk/ds: a minimum variation
curve. Interpolating noisy points exactly would put errors of tens per metre into the curvature.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from model.measurements import Curve, FloatArray, ModelError, SheetGeometry, length_scale
from model.mechanics.collocation import rule
from model.mechanics.field import Field, legendre_field
from model.mechanics.free_shape import free_shape

PENALTY = 1e-5  # weight of int (dk/ds)^2 ds in 1e6/m^3 against squared distances in (10 um)^2

LONGEST_PER_M, ENOUGH_PER_M = 40.0, 1e-6  # a step of the curvature, and one that ends it
# all of these for sheets of the paper's size


@dataclass(frozen=True)
class SmoothCurve:
    """A curve with continuous curvature."""

    curvature: Field
    covariance: FloatArray  # of the coefficients below
    coefficients: FloatArray  # of Legendre polynomials over the free length
    distance_m: FloatArray  # of the measured points along the normal

    def sigma_per_m(self, s_m: FloatArray) -> FloatArray:
        """Return the standard uncertainty of the curvature from the points' scatter."""
        by = np.stack(
            [legendre_field(i, self.curvature.length_m)(s_m) for i in range(len(self.coefficients))]
        )
        variance: FloatArray = np.einsum("is,ij,js->s", by, self.covariance, by)
        return np.sqrt(variance)


@dataclass(frozen=True, kw_only=True)
class Touch:
    """Where a curve meets the arc."""

    s_hat_m: float
    phi_hat_rad: float
    polar_rad: float
    x_m: float
    y_m: float


class _Grid:
    """Integrals of every term along the curve, worked out once for all steps of a fit."""

    def __init__(self, basis: list[Field], s_m: FloatArray) -> None:
        self.rule, length = rule(6), basis[0].length_m
        edges = np.unique(np.concatenate([[0.0, length], s_m]))
        self.h = np.diff(edges)
        nodes = np.minimum(edges[:-1, None] + self.h[:, None] * self.rule.c, length)
        self.turn = np.stack([b.integral(nodes) for b in basis])
        self.places = np.searchsorted(edges, s_m)
        self.turn_at = np.stack([b.integral(np.minimum(s_m, length)) for b in basis])

    def run(self, values: FloatArray) -> FloatArray:
        """Integral of nodal values (..., panels, nodes) up to each s."""
        steps = self.h * (values @ self.rule.b)
        zero = np.zeros((*steps.shape[:-1], 1))
        whole: FloatArray = np.concatenate([zero, np.cumsum(steps, axis=-1)], axis=-1)
        return whole[..., self.places]

    def distance(
        self, c: FloatArray, x_m: FloatArray, y_m: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Of points along the normal of the curve with coefficients c, and its derivatives."""
        phi, end = np.tensordot(c, self.turn, 1), c @ self.turn_at
        nx, ny = -np.sin(end), np.cos(end)
        off = (x_m - self.run(np.cos(phi))) * nx + (y_m - self.run(np.sin(phi))) * ny
        by = self.run(-np.sin(phi) * self.turn) * nx + self.run(np.cos(phi) * self.turn) * ny
        return off, by.T


@lru_cache(maxsize=8)
def _basis_and_grid(count: int, length_m: float, s_m: bytes) -> tuple[list[Field], _Grid]:
    """Return so many Legendre polynomials, with their integrals along points s.

    The curves of a session have the same s as a rule.
    """
    basis = [legendre_field(i, length_m) for i in range(count)]
    return basis, _Grid(basis, np.frombuffer(s_m))


def smooth(curve: Curve, sheet: SheetGeometry, where: str, terms: int | None = None) -> SmoothCurve:
    """Fit a smooth curve from the clamp through the points of sheet and elongation."""
    length = sheet.free_length_m
    share = min(1.0, length / sheet.arc_radius_m)
    count = min(terms or 1 + round(5 * share), len(curve.s_m) - 1)
    s_m = np.minimum(curve.s_m, length + sheet.elongation_m)
    basis, grid = _basis_and_grid(count, length, s_m.tobytes())
    c = np.zeros(count)
    c[0] = _mean_curvature(curve, length)
    scale = length_scale(sheet)
    penalty = _penalty(count, length) * scale**5  # squared distances by squared slopes of k
    for _ in range(25):
        distance, J = grid.distance(c, curve.x_m, curve.y_m)
        A = J.T @ J + penalty
        step = np.linalg.lstsq(A, J.T @ distance - penalty @ c, rcond=1e-13)[0]
        step *= min(1.0, LONGEST_PER_M / scale / max(float(np.max(np.abs(step))), 1e-9 / scale))
        c = c + step
        if np.max(np.abs(step)) < ENOUGH_PER_M / scale:
            break
    else:
        raise ModelError(f"the curve of condition {where} is no smooth curve from the clamp")
    variance = float(distance @ distance) / max(len(curve.s_m) - count, 1)
    field = sum((k * b for k, b in zip(c[1:], basis[1:], strict=True)), c[0] * basis[0])
    covariance = variance * np.asarray(np.linalg.pinv(A), dtype=np.float64)
    return SmoothCurve(field, covariance, c, distance)


def touch(curve: SmoothCurve, sheet: SheetGeometry, where: str) -> Touch:
    """Return the first place where the curve, with its elongation, reaches the arc's radius."""
    R, end = sheet.arc_radius_m, sheet.free_length_m + max(sheet.elongation_m, sheet.arc_radius_m)
    s = np.unique(np.append(np.linspace(0.0, end, 200), sheet.free_length_m))
    x, y, phi = free_shape(curve.curvature, s)
    outside = np.hypot(x, y) >= R
    if not outside.any() or outside[0]:
        raise ModelError(f"the curve of condition {where} does not reach the arc")
    i = int(np.argmax(outside))
    s_hat = float(s[i])
    for _ in range(12):  # Newton, from just beyond
        x, y, phi = free_shape(curve.curvature, np.array([s_hat]))
        radius = float(np.hypot(x[0], y[0]))
        rate = (x[0] * np.cos(phi[0]) + y[0] * np.sin(phi[0])) / radius
        step = (radius - R) / max(float(rate), 0.05)
        s_hat -= float(np.clip(step, -s[1], s[1]))
        if abs(step) < 1e-13:
            break
    return Touch(
        s_hat_m=s_hat,
        phi_hat_rad=float(phi[0]),
        polar_rad=float(np.arctan2(y[0], x[0])),
        x_m=float(x[0]),
        y_m=float(y[0]),
    )


def _mean_curvature(curve: Curve, length_m: float) -> float:
    """From the direction of the points at the sheet's end."""
    angles = np.unwrap(np.arctan2(np.diff(curve.y_m), np.diff(curve.x_m)))
    middle = 0.5 * (curve.s_m[1:] + curve.s_m[:-1])
    beyond = middle >= length_m
    if beyond.sum() >= 3:
        return float(np.median(angles[beyond])) / length_m
    return float(np.polyfit(middle, angles, 1)[0])


@lru_cache(maxsize=32)
def _penalty(count: int, length_m: float) -> FloatArray:
    """Return what squares of dk/ds cost, for the coefficients of Legendre polynomials."""
    basis = [legendre_field(i, length_m) for i in range(count)]
    return PENALTY * 1e-16 * np.array([[_slopes(a, b, length_m) for b in basis] for a in basis])


def _slopes(a: Field, b: Field, length_m: float) -> float:
    """Integral of da/ds db/ds."""
    s = np.linspace(0.0, length_m, 101)
    h = s[1] - s[0]
    return float(np.sum(np.diff(a(s)) * np.diff(b(s))) / h)
