"""The pixels beside a curve, and the cells of the sheet that tell of a face."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.context import CrossSection, FitContext, Pixels, pixels_beside
from labrig.vision.fit.curve_fit import CurveFit
from labrig.vision.thresholds import FREE_PART_USED_SHARE_MIN

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

SHIFT_MAX_PX = 6.0  # from the middle of edge and face to the edge's own


class PixelsBeside:
    """The pixels beside a curve."""

    def __init__(self, fit: CurveFit, context: FitContext, reach: float, *, on_edge: bool) -> None:
        self.shape, self.reach, self.on_edge = fit.shape, reach, on_edge
        self.pixels = pixels_beside(fit.shape, context, reach)

    def pixels_for(self, section: CrossSection) -> Pixels:
        """Return the pixels with distances from the edge's middle, where the curve may not run."""
        if self.on_edge or section.side_face_share == 0:
            return self.pixels
        value, distance, first = self.pixels
        return value, distance + np.repeat(self.lateral_bias_px(section), np.diff(first)), first

    def lateral_bias_px(self, section: CrossSection) -> FloatArray:
        """Return (cells,) from the edge's middle to that of edge and face."""
        thick, grey = 2 * section.half_width, section.side_face_share * np.abs(section.side_face)
        middle = (
            np.sign(section.side_face)
            * grey
            * (thick + np.abs(section.side_face))
            / 2
            / (thick + grey)
        )
        return np.asarray(np.clip(middle, -SHIFT_MAX_PX, SHIFT_MAX_PX))


def cells_to_explain(fit: CurveFit) -> BoolArray:
    """Return (cells,) what tells of a face.

    Also a free sheet that looks wide, where there is little.
    """
    section = fit.section
    free = ~section.elongation & fit.in_view
    if section.corrupted is not None:
        free &= ~section.corrupted
    free[: round(2.5 * section.blur) + 1] = False  # the clamp's blurred edge
    hardly_used = free.any() and fit.used[free].mean() < FREE_PART_USED_SHARE_MIN
    return fit.used | free if section.elongation.any() and hardly_used else fit.used
