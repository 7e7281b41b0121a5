"""Places on a strip that somebody has stated, as measurements of its curve.

Where an edge is hidden they say where the strip is; edges that contradict one are another thing's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

PLACE_SIGMA_PX = 1.5  # of a place that is stated, across the strip
PLACE_SIGMA_WIDTHS = 0.05  # or so much of a thick one, whichever is more
NEAR_WIDTHS, NEAR_MIN_PX = 1.0, 6.0  # along the strip: what must agree with a place
APART_WIDTHS, APART_MIN_PX = 0.35, 4.0  # across it: what contradicts one


@dataclass(frozen=True, eq=False, kw_only=True)
class StatedPlaces:
    """Places in the sheet's plane, in pixels, with their standard deviations across the strip."""

    plane_px: FloatArray  # (places, 2)
    sigma_px: FloatArray  # (places,)

    @classmethod
    def of(cls, optics: Optics, width_px: float) -> StatedPlaces:
        """Return the places that `optics` states on a strip so thick, and its clamp with them."""
        if not optics.stated_places_px:
            return cls(plane_px=np.empty((0, 2)), sigma_px=np.empty(0))
        usual = max(PLACE_SIGMA_PX, PLACE_SIGMA_WIDTHS * width_px)
        sigma = np.full(1 + len(optics.stated_places_px), usual)
        sigma[0] = max(usual, optics.clamp_sigma_px)
        places = [optics.clamp_px, *optics.stated_places_px]
        return cls(plane_px=optics.pixel_to_world(places) * optics.px_per_m, sigma_px=sigma)

    def beside(self, shape: CurveShape) -> tuple[IntArray, FloatArray]:
        """Return (places,) the curve's nearest nodes, and how far to its left the places lie."""
        x, y = self.plane_px.T
        apart = np.hypot(shape.x[None] - x[:, None], shape.y[None] - y[:, None])
        node = apart.argmin(axis=1).astype(np.int64) if len(x) else np.empty(0, np.int64)
        sin, cos = np.sin(shape.phi[node]), np.cos(shape.phi[node])
        return node, cos * (y - shape.y[node]) - sin * (x - shape.x[node])

    def information(self, shape: CurveShape) -> tuple[FloatArray, FloatArray]:
        """Return what the places add to the normal matrix and the right-hand side of a fit."""
        node, offset = self.beside(shape)
        modes = shape.normal_modes()[node] / self.sigma_px[:, None]
        normal = modes.T @ modes
        return normal, modes.T @ (offset / self.sigma_px) + normal @ shape.parameters

    def contradicted(
        self, shape: CurveShape, node: IntArray, middle_px: FloatArray, width_px: float
    ) -> BoolArray:
        """Return (nodes,) which middles, to the left of a curve, lie elsewhere than a place."""
        found = np.zeros(len(node), dtype=bool)
        s = shape.basis.s
        near = max(NEAR_WIDTHS * width_px, NEAR_MIN_PX)
        most = max(APART_WIDTHS * width_px, APART_MIN_PX)
        for at, offset in zip(*self.beside(shape), strict=True):
            beside = np.abs(s[node] - s[at]) < near
            found |= beside & (np.abs(middle_px - offset) > most)
        return found
