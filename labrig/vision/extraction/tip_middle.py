"""Measure the middle of a strip's tip by how much of it differs from the ground as the strip does.

The tip's own edge pulls the two edges beside it, so blocks there are left out, and a smooth curve
that is led on over a strip's width leaves the middle of a tip that is rounded, cut askew or bent.
What lies between strip and ground in brightness, half and half, is its outline there; the middle of
that is known well enough beside the tip alone, for elsewhere both edges are known better.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.fit.outline_profiles import greys_beside
from labrig.vision.image.image import GreyImage
from labrig.vision.thresholds import TIP_CONTRAST_MIN_SCATTERS, TIP_MIDDLE_SEEN_SHARE_MIN

FloatArray = npt.NDArray[np.float64]

UNIT_RATIO, UNIT_MAX_PX = 0.04, 0.5  # step across, in widths
LEARNED_WIDTHS, LAST_WIDTHS = 5.0, 0.5  # before the end: so the strip and its ground look
TIP_WIDTHS, ROUND_WIDTHS = 0.6, 0.1  # before the end: where the middle is measured
INSIDE_WIDTHS = 0.25  # to each side of the curve: the strip, whatever its edges are
GROUND_WIDTHS, GROUND_PX = (0.75, 1.3), (1.0, 2.0)  # to each side: the ground
SMOOTHED_WIDTHS = 0.1  # along the strip, to each side
HALF = 0.5  # of the way from the ground's brightness to the strip's
APART_WIDTHS = (0.25, 1.6)  # of a tip's two sides: else it is no outline of a tip
ROWS_MIN = 3
SCATTER_MIN = 0.4  # grey levels, of drawings without noise


def tip_middle_px(
    shape: CurveShape, images: Sequence[GreyImage], optics: Optics, width_px: float
) -> float | None:
    """Return how far to the left of a curve's end its tip's middle lies; None where not seen."""
    before_end, across, strip = _strip_at_end(shape, images, optics, width_px)
    if strip is None:
        return None
    strip = _smoothed(strip, round(SMOOTHED_WIDTHS * width_px / shape.basis.step_px))
    tip = (before_end < TIP_WIDTHS * width_px) & (before_end >= ROUND_WIDTHS * width_px)
    middles = _middles(strip[tip], across, width_px)
    if len(middles) < max(ROWS_MIN, TIP_MIDDLE_SEEN_SHARE_MIN * int(tip.sum())):
        return None
    return float(np.mean(middles))  # a line through them ends far aside where the end is wrong


def strip_shown(
    shape: CurveShape,
    images: Sequence[GreyImage],
    optics: Optics,
    width_px: float,
    *,
    last_px: float,
) -> bool:
    """Return whether all of the last part of a curve looks like the strip's middle before it."""
    before_end, across, strip = _strip_at_end(shape, images, optics, width_px, last_px=last_px)
    if strip is None:
        return False
    last = before_end < last_px
    middle = strip[last][:, np.abs(across) < INSIDE_WIDTHS * width_px].mean(axis=1)
    return bool((middle > HALF).all())


def _strip_at_end(
    shape: CurveShape,
    images: Sequence[GreyImage],
    optics: Optics,
    width_px: float,
    *,
    last_px: float = 0.0,
) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Return how far before a curve's end, and across, its last part lies, and how much is strip.

    `last_px`: before the end, that may not be the strip.
    """
    s, total = shape.basis.s, shape.basis.total_px
    first = int(np.searchsorted(s, total - last_px - LEARNED_WIDTHS * width_px))
    last = shape.from_node(first)
    before_end = total - s[first:]
    unit = min(UNIT_MAX_PX, UNIT_RATIO * width_px)
    many = math.ceil((GROUND_WIDTHS[1] * width_px + GROUND_PX[1]) / unit)
    across = np.asarray(np.arange(-many, many + 1) * unit, dtype=np.float64)
    greys = greys_beside(last, images, optics, across)
    known = before_end > last_px + LAST_WIDTHS * width_px
    return before_end, across, _share_of_strip(greys, across, known, width_px)


def _share_of_strip(
    greys: Sequence[FloatArray], across: FloatArray, known: npt.NDArray[np.bool_], width_px: float
) -> FloatArray | None:
    """Return (nodes, across) how far the image is from the ground to the strip, 0 to 1.

    All channels together, by the ground's scatter; None where it hides the difference.
    """
    near, far = (w * width_px + px for w, px in zip(GROUND_WIDTHS, GROUND_PX, strict=True))
    inside = np.abs(across) < INSIDE_WIDTHS * width_px
    beside = (np.abs(across) > near) & (np.abs(across) < far)
    total, size = np.zeros_like(greys[0]), 0.0
    for grey in greys:
        own, ground = grey[known][:, inside], grey[known][:, beside]
        if not np.isfinite(own).any() or not np.isfinite(ground).any():
            return None
        level = float(np.nanmedian(ground))
        apart = float(np.nanmedian(own)) - level
        scatter = max(float(np.nanstd(ground)), SCATTER_MIN)
        total += np.nan_to_num(grey - level) * apart / scatter**2
        size += (apart / scatter) ** 2
    return total / size if size > TIP_CONTRAST_MIN_SCATTERS**2 else None


def _smoothed(share: FloatArray, half: int) -> FloatArray:
    import cv2

    rows = 2 * max(1, half) + 1
    return np.asarray(cv2.blur(share, (1, rows), borderType=cv2.BORDER_REPLICATE))


def _middles(share: FloatArray, across: FloatArray, width_px: float) -> list[float]:
    """Return the middles between the tip's two sides, where both are seen."""
    least, most = (ratio * width_px for ratio in APART_WIDTHS)
    middles, at = list[float](), 0.0
    for row in share > HALF:
        centre = int(np.argmin(np.abs(across - at)))  # the tip leads on from where it was before
        if not row[centre]:
            continue
        outside = np.flatnonzero(~row)
        low, high = outside[outside < centre], outside[outside > centre]
        if not len(low) or not len(high):
            continue
        left, right = across[low[-1]], across[high[0]]
        if least < right - left < most:
            at = 0.5 * float(left + right)
            middles.append(at)
    return middles
