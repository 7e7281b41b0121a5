"""The linear beam: y'' = k0 + kappa a(s) - (N/B)(R - x), so that y(R) = R beta at the rolls.

a is the form of the active curvature along the sheet: 1 for a uniform Me, kappa = Me/B. The rolls
touch at x = R; beyond the sheet the elongation goes on straight. F = N, as deflections are small.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.measurements import FloatArray, ModelError
from model.mechanics.field import HIGHEST_DEGREE, Field

GAUSS = np.polynomial.legendre.leggauss((HIGHEST_DEGREE + 3) // 2)


def heights_m(curvature: Field, x_m: FloatArray) -> FloatArray:
    """Return y (x,) of a curvature: int (x - s) k ds over the sheet up to x; exact."""
    x = np.asarray(x_m, dtype=float)
    edges = np.unique(np.concatenate([curvature.breaks_m, np.clip(x, 0.0, curvature.length_m)]))
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    s, w = middle + half * GAUSS[0], half * GAUSS[1]
    turned = w * curvature(s)
    sums = np.stack([np.sum(turned, axis=1), np.sum(turned * s, axis=1)])
    first, second = np.concatenate([np.zeros((2, 1)), np.cumsum(sums, axis=1)], axis=1)
    at = np.searchsorted(edges, np.minimum(x, curvature.length_m))
    return np.asarray(x * first[at] - second[at])


@dataclass(frozen=True)
class LinearBeam:
    """A sheet, free or against the rolls."""

    rest: Field  # k0
    active: Field  # a
    contact_m: float | None = None  # R; None: free
    angle_rad: float = 0.0  # beta

    @cached_property
    def lever(self) -> Field:
        """Return the curvature B/N of a force at the rolls, R - s up to there."""
        R, length = self._at, self.rest.length_m
        if length <= R:
            return Field.linear(np.array([0.0, length]), np.array([R, R - length]), length)
        return Field.linear(np.array([0.0, R, length]), np.array([R, 0.0, 0.0]), length)

    @cached_property
    def off_at_rest_m(self) -> float:
        """Return how far the rolls' place would move without voltage, were they taken away."""
        return self._there(self.rest) - self._at * self.angle_rad

    @cached_property
    def bent_m2(self) -> float:
        """Return how far it moves for kappa = 1/m."""
        return self._there(self.active)

    @cached_property
    def compliance_m3(self) -> float:
        """Return B y at the rolls for each newton there."""
        return self._there(self.lever)

    def force_over_B(self, kappa_per_m: FloatArray) -> FloatArray:
        """Return F/B, (n,)."""
        return (self.off_at_rest_m + kappa_per_m * self.bent_m2) / self.compliance_m3

    def heights_m(self, x_m: FloatArray, kappa_per_m: FloatArray) -> FloatArray:
        """Return y (n, x), with the rolls' force where there is one."""
        y = heights_m(self.rest, x_m) + np.outer(kappa_per_m, heights_m(self.active, x_m))
        if self.contact_m is None:
            return np.asarray(y)
        back = np.outer(self.force_over_B(kappa_per_m), heights_m(self.lever, x_m))
        return np.asarray(y - back)

    @property
    def _at(self) -> float:
        if self.contact_m is None:
            raise ModelError("a free sheet has no contact")
        return self.contact_m

    def _there(self, curvature: Field) -> float:
        return float(heights_m(curvature, np.array([self._at]))[0])
