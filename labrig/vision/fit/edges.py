"""Place a thick strip's curve midway between its edges, unaffected by light and shade across it.

The fit's cross-section has two equally bright halves; where light falls on one of them more
the middle of the light lies beside that of the strip. Its edges are where the image changes most,
however bright each half is: they are searched in the camera's own pixels, which show them apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit
from labrig.vision.image.downscaling import scaled_places
from labrig.vision.thresholds import (
    EDGE_BLOCK_USED_SHARE_MIN,
    EDGE_BLOCKS_SHARE_MIN,
    EDGE_DISTANCE_RATIOS,
)

FloatArray = npt.NDArray[np.float64]

# in units of the thickness
STEP_RATIO, REACH_RATIO = 0.04, 1.3
# from the curve to an edge: nearer, light ends and shade begins
NEAREST_RATIO, FARTHEST_RATIO = 0.25, 1.0
SMOOTHING_RATIO = 0.08
SPREAD_MIN_RATIO = 0.005
MEAN_HALF_BLOCKS = 4  # blocks to each side whose mean gives the middle


@dataclass(frozen=True, eq=False)
class Middle:
    """Where the middle between the edges lies beside the curve, in the fit context's pixels."""

    offset_px: FloatArray  # (cells,)
    sigma_px: float  # of each cell, were it alone: edges are frayed


def middle_of_edges(fit: CurveFit, context: FitContext) -> Middle | None:
    """Return the edges' middle beside a fitted curve; None where hardly both edges are seen."""
    thick_px = 2 * np.append(fit.section.half_width, fit.section.half_width[-1])
    many = max(1, round(float(thick_px[0]) / fit.shape.basis.step_px))
    blocks = len(fit.used) // many
    if blocks < 2 * MEAN_HALF_BLOCKS:
        return None
    used = fit.used[: blocks * many].reshape(blocks, many).mean(axis=1) > EDGE_BLOCK_USED_SHARE_MIN
    strip = _straightened(fit, context, thick_px)[: blocks * many]
    low, high = _edges(strip.reshape(blocks, many, -1).mean(axis=1))
    apart = high - low
    least, most = EDGE_DISTANCE_RATIOS
    good = used & (apart > least) & (apart < most)
    if good.mean() < EDGE_BLOCKS_SHARE_MIN:
        return None
    at = (np.arange(blocks) + 0.5) * many
    beside = (0.5 * (low + high) * thick_px[at.astype(int)])[good]
    few, smooth = _smoothed(beside)
    spread = max(1.48 * float(np.median(np.abs(beside - smooth))), SPREAD_MIN_RATIO * thick_px[0])
    cells = np.arange(len(fit.used)) + 0.5
    # neighbours are frayed alike: every third block is independent
    sigma = spread * float(np.sqrt(3 * many))
    return Middle(np.interp(cells, at[good], few), sigma)


def _straightened(fit: CurveFit, context: FitContext, thick_px: FloatArray) -> FloatArray:
    """Return (nodes, places across) the camera's grey along the curve, NaN outside."""
    import cv2

    shape, image = fit.shape, context.image
    across = _places() * thick_px[:, None]
    x = shape.x[:, None] - np.sin(shape.phi)[:, None] * across
    y = shape.y[:, None] + np.cos(shape.phi)[:, None] * across
    plane = np.stack([x.ravel(), y.ravel()], axis=1) / context.optics.px_per_m
    uv = scaled_places(context.optics.world_to_pixel(plane), image.downscaling)
    uv = uv.reshape(*x.shape, 2).astype(np.float32)
    grey = cv2.remap(
        image.full_resolution,
        uv[..., 0],
        uv[..., 1],
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=float("nan"),
    )
    return np.asarray(context.sign * grey, dtype=np.float64)


def _places() -> FloatArray:
    return np.arange(-REACH_RATIO, REACH_RATIO + STEP_RATIO / 2, STEP_RATIO)


def _edges(profiles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (blocks,) places of the steepest rise below the curve and steepest fall above it.

    NaN where there is none.
    """
    t = (
        np.arange(
            -round(4 * SMOOTHING_RATIO / STEP_RATIO), round(4 * SMOOTHING_RATIO / STEP_RATIO) + 1
        )
        * STEP_RATIO
        / SMOOTHING_RATIO
    )
    kernel = -t * np.exp(-t * t / 2)  # the slope of a bell
    slope = np.stack([np.convolve(row, kernel, mode="same") for row in profiles])
    return _steepest(slope, -FARTHEST_RATIO, -NEAREST_RATIO), _steepest(
        -slope, NEAREST_RATIO, FARTHEST_RATIO
    )


def _steepest(slope: FloatArray, low: float, high: float) -> FloatArray:
    """Return (blocks,) place of the highest peak between two places, to a part of a step."""
    places = _places()
    part = (places >= low) & (places <= high)
    part &= np.abs(places) < REACH_RATIO - 4 * SMOOTHING_RATIO
    inside, rows = places[part], np.arange(len(slope))
    seen = np.nan_to_num(slope[:, part], nan=-np.inf)
    peak = seen.argmax(axis=1)
    whole = (peak > 0) & (peak < len(inside) - 1)
    peak = np.clip(peak, 1, len(inside) - 2)
    before, at, after = (seen[rows, peak + q] for q in (-1, 0, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        beside = 0.5 * (before - after) / (before - 2 * at + after)
    return np.where(whole & (at > 0), inside[peak] + beside * STEP_RATIO, np.nan)


def _smoothed(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return medians of few, as threads are outliers, and means of some of these."""
    windows = np.lib.stride_tricks.sliding_window_view
    few = np.median(windows(np.pad(values, 2, mode="reflect"), 5), axis=1)
    return few, windows(
        np.pad(few, MEAN_HALF_BLOCKS, mode="reflect"), 2 * MEAN_HALF_BLOCKS + 1
    ).mean(axis=1)
