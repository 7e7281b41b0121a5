"""The input of a check for a curve that was found between two edges.

It has the parts of a `SeenCurve` that such a curve has, under the same names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.fit.outline import OutlineFit
from labrig.vision.image.image import GreyImage

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class OutlineContext:
    """The image of a curve between two edges, and where it is in it."""

    image: GreyImage
    channels: Sequence[GreyImage]  # the image in all channels in which edges were looked for
    optics: Optics
    sign: float  # +1: the strip is brighter than its ground

    def nodes_px(self, shape: CurveShape) -> FloatArray:
        """Return (nodes, 2) a curve's places in the image."""
        plane = np.stack([shape.x, shape.y], axis=1)
        return np.asarray(self.optics.world_to_pixel(plane / self.optics.px_per_m))


@dataclass(frozen=True, eq=False, kw_only=True)
class SeenOutline:
    """A curve between two edges with its image; see `SeenCurve` for what the parts are."""

    fit: OutlineFit
    context: OutlineContext
    sigma_px: FloatArray
    edges_seen: bool = True  # else it follows a path through stated places
    end_measured: bool  # inside of the image; neither the length nor the tip is stated

    @property
    def image(self) -> GreyImage:
        """The image: `grey` (rows, columns), its noise and its warnings."""
        return self.context.image

    @property
    def covered(self) -> float:
        """Share of the length on which both edges are seen."""
        return float(self.fit.blocks.seen.mean()) if self.edges_seen else 0.0

    @property
    def residual_px(self) -> float:
        """RMS distance between the curve and the middles of the blocks."""
        return self.fit.residual_px

    def pixel(self, node: int) -> tuple[float, float]:
        """Return where a point of the curve is in the image, column and row."""
        u, v = self.context.nodes_px(self.fit.shape)[node]
        return float(u), float(v)

    @property
    def length_mm(self) -> float:
        """Length from the clamp to the end."""
        return self.fit.shape.basis.total_px / self.context.optics.px_per_mm
