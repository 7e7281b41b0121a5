"""The input of a check of a curve: the fit, its image, and the measurements on both."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from labrig.vision.checks.gap_continuity import GapJoin, worst_join
from labrig.vision.checks.sheet_end import SheetEnd
from labrig.vision.curve.background_lines import BackgroundLine
from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit
from labrig.vision.image.image import GreyImage
from labrig.vision.thresholds import LENGTH_ERROR_MAX_PX, LENGTH_ERROR_MAX_RATIO
from labrig.vision.uncertainty.residual_offset import offset_px

FloatArray = npt.NDArray[np.float64]
START_CELLS_MIN = 20


@dataclass(frozen=True, eq=False, kw_only=True)
class SeenCurve:
    """A fitted curve with its image. What is measured on them is measured when it is first read.

    A curve is checked up to three times; see `CheckStage`. What a later stage adds is 0 or empty
    before it.
    """

    fit: CurveFit
    context: FitContext
    sheet_end: SheetEnd
    followed: bool = False  # from the image before, whose end and surroundings were checked
    beside_checked: bool = True  # whether what lies beside the curve is to be checked
    # of the chosen curve:
    excess_px: FloatArray | None = None  # (nodes,): how much wider it looks than it is thick
    lateral_bias_px: FloatArray | None = None  # (nodes,): how far what touches it may pull it
    second_sheet: float = 0.0  # contrast of a second sheet at the clamp, over that of this one
    wires: tuple[BackgroundLine, ...] = ()  # background lines whose pixels were left out
    left_out_along: bool = False  # whether cells were left out where something lies along it
    # of the curve with its whole uncertainty:
    sigma_px: FloatArray | None = None  # (nodes,): one standard deviation along the normal

    @property
    def image(self) -> GreyImage:
        """The image: `grey` (rows, columns), its noise and its warnings."""
        return self.context.image

    @cached_property
    def join(self) -> GapJoin:
        """The least likely join of what is seen before and beyond a hidden stretch."""
        return worst_join(self.fit, self.context)

    @cached_property
    def residual_px(self) -> float:
        """RMS distance between the curve and the sheet as measured in pieces of 15 pixels."""
        return smooth_residual_px(self.fit)

    @cached_property
    def offset_px(self) -> FloatArray:
        """(nodes,) how far beside the curve the image shows the sheet."""
        return offset_px(self.fit, self.context)

    @cached_property
    def covered(self) -> float:
        """Share of the length on which the sheet is seen."""
        return float(self.fit.used[2:-2].mean())

    @property
    def length_mm(self) -> float:
        """Stated length from the clamp to the end."""
        return self.fit.shape.basis.total_px / self.context.optics.px_per_mm

    @property
    def length_error_max_px(self) -> float:
        """Largest allowed distance of the seen end from the stated one."""
        total = self.fit.shape.basis.total_px
        return max(LENGTH_ERROR_MAX_PX, LENGTH_ERROR_MAX_RATIO * total)

    @property
    def start_cells(self) -> int:
        """Cells of the start: the first eighth."""
        return max(START_CELLS_MIN, len(self.fit.used) // 8)

    def seen_share(self, cells: slice) -> float:
        """Return how much of the visible part of some cells looks like the sheet; 1: none is."""
        used, in_view = self.fit.used[cells], self.fit.in_view[cells]
        return float(used.sum() / in_view.sum()) if in_view.any() else 1.0

    def pixel(self, node: int) -> tuple[float, float]:
        """Return where a point of the curve is in the image, column and row."""
        u, v = self.context.nodes_px(self.fit.shape)[node]
        return float(u), float(v)

    def with_sigma(self, sigma_px: FloatArray) -> SeenCurve:
        """Return it with its whole uncertainty (nodes,)."""
        return replace(self, sigma_px=sigma_px)

    def along(self, values: FloatArray | None) -> FloatArray:
        """Return values (nodes,); zeros where they were not measured."""
        return np.zeros(len(self.fit.shape.x)) if values is None else values


def smooth_residual_px(fit: CurveFit) -> float:
    """Return RMS distance between the curve and the sheet as measured in pieces of 15 pixels."""
    offset, sigma = fit.offsets_px
    weight = np.where(fit.used, 1 / np.maximum(sigma, 1e-6) ** 2, 0.0)
    box = np.ones(15)
    total = np.convolve(weight, box, mode="same")
    mean = np.convolve(weight * np.clip(offset, -3, 3), box, mode="same")
    seen = fit.used & (total > 0)
    if not seen.any():
        return float("inf")
    return float(np.sqrt(np.mean((mean[seen] / total[seen]) ** 2)))
