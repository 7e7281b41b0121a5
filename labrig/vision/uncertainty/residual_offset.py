"""Measure how far beside the curve the image shows the sheet.

A frayed strip, or one that looks much thicker in one place, is not drawn as the fit's band has it:
there cells are left out, and a smooth curve bridges them, or misses them by more than their noise.
Whatever the reason, the image differs there, and the credible band must hold that.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit, around, ridge_points
from labrig.vision.thresholds import (
    OFFSET_CELLS_MIN,
    OFFSET_CHI2_MAX,
    OFFSET_PRESENT_SHARE_MIN,
    OFFSET_SLOPE_MAX,
    SHEET_LIKE_RATIOS,
)

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

PIECE_HALF_CELLS = 5  # to each side, whose offsets are averaged
MEAN_HALF_CELLS = 25  # to each side, over which chi square is averaged
UNCLEAR_HALF_CELLS = 12  # to each side, of unclear ones


def offset_px(fit: CurveFit, context: FitContext) -> FloatArray:
    """Return (nodes,) how far beside the curve the image shows the sheet; 0: where the curve is."""
    beside = np.where(fit.used, _of_used(fit), 0.0)
    # by cells the share of pixels is uneven
    unclear = ~fit.used & (around(fit.present, 2) > 5 * OFFSET_PRESENT_SHARE_MIN)
    if fit.section.corrupted is not None:
        unclear &= ~fit.section.corrupted  # that is known to be something else
    edge = round(2.5 * fit.section.blur) + 1
    unclear[:edge] = unclear[-edge:] = False  # of the clamp, and of the sheet itself
    if unclear.sum() > OFFSET_CELLS_MIN:
        beside = np.maximum(beside, _of_unclear(fit, context, unclear))
    return np.append(beside, beside[-1])


def _of_used(fit: CurveFit) -> FloatArray:
    """Return (cells,) the mean offset of neighbouring cells, where it is clearly above noise."""
    offset, sigma = fit.offsets_px
    weight = np.where(fit.used, 1 / np.maximum(sigma, 1e-6) ** 2, 0.0)
    total = np.maximum(around(weight, PIECE_HALF_CELLS), 1e-9)
    square = np.where(fit.used, (around(weight * offset, PIECE_HALF_CELLS) / total) ** 2, 0.0)
    many = np.maximum(around(fit.used, MEAN_HALF_CELLS), 1.0)
    chi2 = around(square * total, MEAN_HALF_CELLS) / many
    noise = around(np.where(fit.used, 1 / total, 0.0), MEAN_HALF_CELLS) / many
    more = around(square, MEAN_HALF_CELLS) / many - noise
    return np.where(chi2 > OFFSET_CHI2_MAX, np.sqrt(np.maximum(more, square)), 0.0)


def _of_unclear(fit: CurveFit, context: FitContext, unclear: BoolArray) -> FloatArray:
    """Return (cells,) the middle of what looks like the sheet, but not as the fit's band has it."""
    half = float(fit.section.half_width.max())
    reach = np.full(len(fit.used) + 1, round(2 * half + 10))
    offset, height, width = (each[1:] for each in ridge_points(fit.shape, context, reach))
    found = np.isfinite(offset)
    usual = fit.used & found
    if not usual.any():
        return np.zeros(len(unclear))
    # what crosses the sheet leads away from it
    like = found & (np.abs(offset) < 0.5 * width) & (np.abs(np.gradient(offset)) < OFFSET_SLOPE_MAX)
    for seen in (height, width):
        low, high = (share * float(np.median(seen[usual])) for share in SHEET_LIKE_RATIOS)
        like &= (seen > low) & (seen < high)
    like &= unclear
    many = around(like, UNCLEAR_HALF_CELLS)
    mean = around(np.where(like, offset, 0.0), UNCLEAR_HALF_CELLS) / np.maximum(many, 1.0)
    aside = np.pad(np.where(many > OFFSET_CELLS_MIN, np.abs(mean), 0.0), UNCLEAR_HALF_CELLS)
    # at its ends hardly half a piece is left, and beside them the fit follows one edge of two
    windows = np.lib.stride_tricks.sliding_window_view(aside, 2 * UNCLEAR_HALF_CELLS + 1)
    return np.asarray(windows.max(axis=1))
