"""Find stretches of a curve that cannot be the sheet: a sheet hides what is behind it.

Before another ground its own grey continues; where that is the ground's, too, the sheet disappears.
What shows there instead, such as a wire, is as much brighter or darker as that ground is.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.curve_fit import CurveFit
from labrig.vision.thresholds import (
    GROUND_CHANGE_MIN_RATIO,
    OCCLUSION_GAP_MIN_CELLS,
    SEE_THROUGH_MIN_RATIO,
    SHADE_DIFFERENCE_MIN_RATIO,
)

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

STRETCH_END_CELLS = 12  # cells of a stretch that give its greys beside a gap


def see_through_cells(fit: CurveFit) -> BoolArray:
    """Return (cells,) of stretches between two gaps whose grey changes with the ground."""
    see_through = np.zeros(len(fit.used), dtype=bool)
    stretches = _stretches(fit.used)
    if len(stretches) < 3:
        return see_through
    steps = [_step(fit, before, after) for before, after in pairwise(stretches)]
    for stretch, (into, out) in zip(stretches[1:-1], pairwise(steps), strict=True):
        if _is_seen_through(*into) and _is_seen_through(*out) and into[0] * out[0] < 0:
            see_through[stretch] = True
    return see_through


def _stretches(used: BoolArray) -> list[slice]:
    """Return where a curve is seen, without small holes."""
    at = np.flatnonzero(used)
    if not len(at):
        return []
    breaks = np.flatnonzero(np.diff(at) > OCCLUSION_GAP_MIN_CELLS)
    firsts, lasts = np.append(at[0], at[breaks + 1]), np.append(at[breaks], at[-1])
    return [slice(int(first), int(last) + 1) for first, last in zip(firsts, lasts, strict=True)]


def _step(fit: CurveFit, before: slice, after: slice) -> tuple[float, float, float]:
    """Return how ground and sheet change over a gap, in units of the contrast.

    The latter under shade.
    """
    contrast = fit.usual_contrast
    one = _greys(fit, slice(max(before.start, before.stop - STRETCH_END_CELLS), before.stop))
    other = _greys(fit, slice(after.start, min(after.stop, after.start + STRETCH_END_CELLS)))
    ground, sheet = (other - one) / contrast
    return float(ground), float(sheet), float(ground * one[1] / max(one[0], 1.0))


def _greys(fit: CurveFit, part: slice) -> FloatArray:
    """Return (2,) of ground and sheet."""
    ground = fit.cells[part, 1][fit.used[part]]
    contrast = fit.contrast[part][fit.used[part]]
    return np.array([np.median(ground), np.median(ground + contrast)])


def _is_seen_through(ground: float, sheet: float, shaded: float) -> bool:
    """Return whether a ground shows through; a shadow's edge, which darkens both, does not."""
    through = abs(ground) > GROUND_CHANGE_MIN_RATIO and sheet / ground > SEE_THROUGH_MIN_RATIO
    return through and abs(sheet - shaded) > SHADE_DIFFERENCE_MIN_RATIO * abs(ground)
