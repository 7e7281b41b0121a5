"""A side face: how wide it shows, and the band that it makes of a section."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.curve.shape import CurveShape
from labrig.vision.fit.context import CrossSection

FloatArray = npt.NDArray[np.float64]

SIDE_FACE_WIDTH_MAX_PX = 24.0


@dataclass(frozen=True, kw_only=True)
class SideFace:
    """How the side face shows; lengths in pixels of the sheet's plane."""

    depth: float
    share: float
    centre: tuple[float, float]
    blur: float  # of the edges, which is less when the face is not taken for blur
    elongation_half: float  # half the elongation's visible thickness, which nobody knows

    def widths(self, shape: CurveShape) -> FloatArray:
        """Return (cells,) visible width, to the side of its sign."""
        x, y = 0.5 * (shape.x[1:] + shape.x[:-1]), 0.5 * (shape.y[1:] + shape.y[:-1])
        phi = 0.5 * (shape.phi[1:] + shape.phi[:-1])
        towards = (self.centre[1] - y) * np.cos(phi) - (self.centre[0] - x) * np.sin(phi)
        return np.asarray(
            np.clip(self.depth * towards, -SIDE_FACE_WIDTH_MAX_PX, SIDE_FACE_WIDTH_MAX_PX)
        )

    def on(self, section: CrossSection, shape: CurveShape) -> CrossSection:
        """Return a band with this face."""
        looking = section.with_look(self.blur, self.elongation_half)
        return replace(looking, side_face=self.widths(shape), side_face_share=self.share)
