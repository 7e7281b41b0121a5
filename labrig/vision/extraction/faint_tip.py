"""Follow a strip's tip beyond where its profile ends: it becomes thinner, or fades into the ground.

There a profile of the strip's whole width is no longer found. What is still seen is a middle that
differs from the ground on both sides as the strip does. It is followed from the strip on, step by
step, for as long as it stands out and the ground beside it stays the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.fit.leading_on import LedOn
from labrig.vision.fit.outline_profiles import greys_beside
from labrig.vision.image.image import GreyImage
from labrig.vision.thresholds import (
    TIP_CONTRAST_MIN_RATIO,
    TIP_CONTRAST_MIN_SIGMAS,
    TIP_GROUND_MAX_RATIO,
    TIP_OTHER_MIN_RATIO,
)

FloatArray = npt.NDArray[np.float64]

UNIT_MIN_PX, UNIT_RATIO = 0.5, 0.025  # steps along and across, in widths
KNOWN_WIDTHS = 4.0  # before the end: so the strip and its ground look
LAST_WIDTHS = 1.0  # before its end: there it may look different already
BEGIN_WIDTHS = 0.5  # before the end: from there the tip is looked at
MIDDLE_WIDTHS = 0.25  # to each side of the curve: the strip, whatever its edges are
GROUND_WIDTHS, GROUND_PX = (0.75, 1.3), (1.0, 2.0)  # to each side: the ground
NARROW_WIDTHS, NARROW_MIN_PX = 0.3, 2.0  # of the tip
LEAST_PX, LEAST_WIDTHS = 1.5, 0.15  # beyond an end: less is within how well it is known
ASIDE_MAX_WIDTHS = 1.2  # further aside is another thing
ASIDE_COST = 0.02  # of a step aside, in the strip's contrast


@dataclass(frozen=True, eq=False)
class TipBeyond:
    """Where a tip ends, and the way there against the curve that was led on."""

    end_px: float
    way: LedOn


def tip_beyond(
    shape: CurveShape, end_px: float, images: Sequence[GreyImage], optics: Optics, width_px: float
) -> TipBeyond | None:
    """Return the tip beyond `end_px` of a curve that was led on; None where there is no more."""
    unit = max(UNIT_MIN_PX, UNIT_RATIO * width_px)
    first = max(0.0, end_px - KNOWN_WIDTHS * width_px)
    s = np.arange(first, shape.basis.total_px, unit)
    many = round((GROUND_WIDTHS[1] * width_px + GROUND_PX[1]) / unit) + 1
    across = np.asarray(np.arange(-many, many + 1) * unit)
    greys = greys_beside(_at(shape, s), images, optics, across)
    known = s < end_px - LAST_WIDTHS * width_px
    narrow = max(1, round(max(NARROW_WIDTHS * width_px, NARROW_MIN_PX) / unit / 2))
    if known.sum() < 2 * narrow:
        return None
    share, ground = _contrast(greys, across, known, width_px)
    if not np.isfinite(share[known]).all():
        return None
    narrow_share = _running_mean(share, narrow)
    beside = _beside(across, width_px)
    least = max(
        TIP_CONTRAST_MIN_RATIO, TIP_CONTRAST_MIN_SIGMAS * narrow_share[known][:, beside].std()
    )
    begin = int(np.searchsorted(s, end_px - LAST_WIDTHS * width_px))
    aside, stands_out = _followed(narrow_share[begin:], unit, width_px)
    goes_on = (stands_out > least) & (stands_out < TIP_OTHER_MIN_RATIO)
    goes_on &= np.abs(ground[begin:]) < TIP_GROUND_MAX_RATIO
    late = s[begin:] > end_px - BEGIN_WIDTHS * width_px
    ends = np.flatnonzero(late & ~goes_on)
    last = int(ends[0]) if len(ends) else len(late) - 1
    new_end = float(s[begin + last])
    if new_end < end_px + max(LEAST_PX, LEAST_WIDTHS * width_px):
        return None
    at, aside = s[begin : begin + last + 1], aside[: last + 1]
    middle = 0.5 * (at[0] + at[-1])
    bend, slope, _ = np.polyfit(at - middle, aside, 2)
    of_tip = at[late[: last + 1]]
    return TipBeyond(new_end, LedOn(of_tip, slope + 2 * bend * (of_tip - middle)))


def _at(shape: CurveShape, s: FloatArray) -> CurveShape:
    along = shape.basis.s
    x, y, phi, k = (np.interp(s, along, each) for each in (shape.x, shape.y, shape.phi, shape.k))
    return replace(shape, x=x, y=y, phi=phi, k=k)


def _beside(across: FloatArray, width_px: float) -> npt.NDArray[np.bool_]:
    near, far = (w * width_px + px for w, px in zip(GROUND_WIDTHS, GROUND_PX, strict=True))
    return np.asarray((np.abs(across) > near) & (np.abs(across) < far))


def _contrast(
    greys: Sequence[FloatArray], across: FloatArray, known: npt.NDArray[np.bool_], width_px: float
) -> tuple[FloatArray, FloatArray]:
    """Return (s, across) how far the image is from the ground beside to the strip, 0 to 1.

    And (s,) how far that ground is from the usual one. All channels together, by their noise.
    """
    inside = np.abs(across) < MIDDLE_WIDTHS * width_px
    beside = _beside(across, width_px)
    total, size = np.zeros_like(greys[0]), 0.0
    for grey in greys:
        ground = grey[known][:, beside]
        apart = float(grey[known][:, inside].mean() - ground.mean())
        noise = max(float(ground.std()), 1e-3)
        total += (grey - ground.mean()) * apart / noise**2
        size += (apart / noise) ** 2
    share = total / max(size, 1e-9)
    base = np.median(share[:, beside], axis=1)
    share = share - base[:, None]
    usual = max(float(np.median(share[known][:, inside])), 1e-3)
    return np.asarray(share / usual), np.asarray(base - np.median(base[known]))


def _running_mean(values: FloatArray, half: int) -> FloatArray:
    """Return the mean over `half` places across to each side, and one along."""
    import cv2

    return np.asarray(cv2.blur(values, (2 * half + 1, 3), borderType=cv2.BORDER_REPLICATE))


def _followed(share: FloatArray, unit: float, width_px: float) -> tuple[FloatArray, FloatArray]:
    """Return (s,) how far aside the way of the most contrast lies, and the contrast along it."""
    middle = share.shape[1] // 2
    at, most = middle, round(ASIDE_MAX_WIDTHS * width_px / unit)
    aside, found = np.zeros(len(share)), np.zeros(len(share))
    for i, row in enumerate(share):
        near = np.arange(max(0, at - 1), min(len(row), at + 2))
        at = int(near[np.argmax(row[near] - ASIDE_COST * np.abs(near - at))])
        if abs(at - middle) > most:
            break
        aside[i], found[i] = (at - middle) * unit, row[at]
    return aside, found
