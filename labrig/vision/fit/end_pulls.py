"""What the own edges of a clamp and of a tip pull the middles of a strip's edges by.

All middles beside such an end are off alike, the less the further away, by an amount that nobody
knows. Where the end is stated, the likeliest amount follows from how far its place lies beside
the middles, and from how well it is known.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.thresholds import OUTLINE_END_SIGMA_MAX_PX, OUTLINE_END_SIGMA_RATIO

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]


def end_pull_px(away_px: FloatArray, width_px: float) -> FloatArray:
    """Return one standard deviation of the pull, so far away from an end."""
    most = min(OUTLINE_END_SIGMA_RATIO * width_px, OUTLINE_END_SIGMA_MAX_PX)
    return np.asarray(most * np.exp(-away_px / width_px))


def likeliest_pull_px(
    away_px: FloatArray,
    middle_px: FloatArray,
    near: BoolArray,
    *,
    width_px: float,
    end_offset_px: float,
    end_sigma_px: float,
    sigmas_max: float,
) -> FloatArray:
    """Return (blocks,) what is to be taken from the middles, which lie so far to the left.

    `near`: the blocks whose middles are compared with the end's place, `end_offset_px` to the
    left of the curve. Further from it than `sigmas_max` they are another thing's, and nothing
    is taken.
    """
    pull = end_pull_px(away_px, width_px)
    if not near.any():
        return np.zeros(len(pull))
    here = float(np.median(pull[near]))
    apart = float(np.median(middle_px[near])) - end_offset_px
    if abs(apart) > sigmas_max * np.hypot(here, end_sigma_px):
        return np.zeros(len(pull))
    return np.asarray(apart * pull * here / (here**2 + end_sigma_px**2))
