"""The linear beam: y'' = k0 + kappa - (N/B)(R - x), so that y(R) = R beta at the contact.

kappa = Me/B is the same all along the sheet. The rolls touch at x = R; beyond the sheet the
elongation goes on straight. F = N, as deflections are small.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.dynamics.models.contract import DrivenSheet, Response
from model.measurements import FloatArray, ModelError, SheetGeometry

PLACES = 41  # of a curve
GAUSS = np.array([-1.0, 1.0]) / np.sqrt(3.0)  # two points, weights 1: exact to degree 3


def rest_curvature(sheet: SheetGeometry, s_m: FloatArray) -> FloatArray:
    """Return k0 at places of the sheet; a sheet without a stated k0 is straight."""
    if sheet.initial_curvature is None:
        return np.zeros_like(s_m)
    return np.interp(s_m, *sheet.initial_curvature)


def mean_rest_curvature(sheet: SheetGeometry, to_m: float) -> float:
    """Return the mean k0 from the clamp to there."""
    s, w = _rule(sheet, to_m)
    return float(w @ rest_curvature(sheet, s)) / to_m


def _rule(
    sheet: SheetGeometry, to_m: float, edges_m: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return places and weights that integrate k0 times a polynomial of degree 2 exactly.

    Between any two edges, too, where some are given.
    """
    given = np.zeros(0) if edges_m is None else edges_m[(edges_m > 0.0) & (edges_m < to_m)]
    edges = np.unique(np.concatenate([[0.0, to_m], given]))
    if sheet.initial_curvature is not None:
        inside = sheet.initial_curvature[0]
        edges = np.unique(np.concatenate([edges, inside[(inside > 0.0) & (inside < to_m)]]))
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    return (middle + half * GAUSS).ravel(), np.repeat(half.ravel(), 2)


def rest_heights_m(sheet: SheetGeometry, x_m: FloatArray) -> FloatArray:
    """Return y (x,) on the sheet without voltage and load: int k0 (x - s) ds."""
    s, w = _rule(sheet, sheet.free_length_m, x_m)
    turn = w * rest_curvature(sheet, s)
    before = s < x_m[:, None]
    return np.asarray(np.sum(before * turn * (x_m[:, None] - s), axis=1))


@dataclass(frozen=True)
class SmallDeflection:
    """The sheet of a run as a linear beam."""

    run: DrivenSheet

    def rest_m(self, x_m: float) -> float:
        """Return y at x of the sheet without voltage and load."""
        end = min(x_m, self.run.sheet.free_length_m)
        if end <= 0.0:
            return 0.0
        s, w = _rule(self.run.sheet, end)
        return float(w @ (rest_curvature(self.run.sheet, s) * (x_m - s)))

    def bent_m2(self, x_m: float) -> float:
        """Return y at x of a sheet of curvature 1/m: int (x - s) ds."""
        end = min(x_m, self.run.sheet.free_length_m)
        return end * x_m - 0.5 * end**2

    def compliance_m3(self, x_m: float) -> float:
        """Return B y at the contact per newton there: int (x - s)^2 ds."""
        beyond = max(x_m - self.run.sheet.free_length_m, 0.0)
        return (x_m**3 - beyond**3) / 3.0

    @cached_property
    def contact_m(self) -> float:
        """Return x of the contact; `ModelError` where the sheet does not reach it."""
        sheet = self.run.sheet
        if sheet.arc_radius_m > sheet.free_length_m + sheet.elongation_m:
            raise ModelError("the sheet and its elongation do not reach the load cell")
        return sheet.arc_radius_m

    @cached_property
    def off_at_rest_m(self) -> float:
        """Return how far the contact would move without voltage, were the load cell taken away."""
        return self.rest_m(self.contact_m) - self.contact_m * self.run.angle_rad

    def force_over_B(self, kappa_per_m: FloatArray) -> FloatArray:
        """Return F/B for curvatures Me/B, (n,)."""
        R = self.contact_m
        return (self.off_at_rest_m + kappa_per_m * self.bent_m2(R)) / self.compliance_m3(R)

    def heights_m(self, x_m: FloatArray, kappa: FloatArray) -> FloatArray:
        """Return y (n, x) of the sheet, with the contact's force where there is one."""
        y = rest_heights_m(self.run.sheet, x_m) + np.outer(kappa, 0.5 * x_m**2)
        if self.run.free:
            return np.asarray(y)
        R = self.contact_m
        loaded = np.minimum(x_m, R)
        shape = R * loaded**2 / 2.0 - loaded**3 / 6.0 + (x_m - loaded) * 0.5 * R**2
        return np.asarray(y - np.outer(self.force_over_B(kappa), shape))

    def response(
        self, B: float, kappa: FloatArray, current_A: FloatArray | None = None
    ) -> Response:
        """Return force, tip and curves for curvatures Me/B (n,), without inertia."""
        length = self.run.sheet.free_length_m
        x = np.linspace(0.0, length, PLACES)
        y = self.heights_m(x, kappa[self.run.frames])
        return Response(
            force_N=None if self.run.free else B * self.force_over_B(kappa),
            current_A=current_A,
            tip_m=self.heights_m(np.array([length]), kappa)[:, 0],
            curves_m=(np.broadcast_to(x, y.shape), y),
        )
