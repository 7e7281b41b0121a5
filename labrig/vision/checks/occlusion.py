"""Stretches of a curve that cannot be the sheet, because a sheet hides what is behind it.

Before another ground its own grey goes on; where that is the ground's, too, the sheet disappears.
What shows there instead, such as a wire, is as much brighter or darker as that ground is.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.curve_fit import CurveFit

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

LEAST_GAP = 3  # cells that are not used, between two stretches
ENDS = 12  # cells of a stretch that say what it looks like beside a gap
OTHER_GROUND = 0.5  # of the sheet's contrast: so much another ground differs
SHINES_THROUGH = 0.3  # of that difference
LIKE_SHADE = 0.25


def see_through_cells(fit: CurveFit) -> BoolArray:
    """(cells,) of stretches between two gaps whose grey changes with the ground."""
    see_through = np.zeros(len(fit.used), dtype=bool)
    stretches = _stretches(fit.used)
    if len(stretches) < 3:
        return see_through
    steps = [_step(fit, before, after) for before, after in pairwise(stretches)]
    for stretch, (into, out) in zip(stretches[1:-1], pairwise(steps), strict=True):
        if _shines(*into) and _shines(*out) and into[0] * out[0] < 0:
            see_through[stretch] = True
    return see_through


def _stretches(used: BoolArray) -> list[slice]:
    """Where a curve is seen, without small holes."""
    at = np.flatnonzero(used)
    if not len(at):
        return []
    breaks = np.flatnonzero(np.diff(at) > LEAST_GAP)
    firsts, lasts = np.append(at[0], at[breaks + 1]), np.append(at[breaks], at[-1])
    return [slice(int(first), int(last) + 1) for first, last in zip(firsts, lasts, strict=True)]


def _step(fit: CurveFit, before: slice, after: slice) -> tuple[float, float, float]:
    """How ground and sheet change over a gap, in units of the contrast; the latter under shade."""
    contrast = fit.usual_contrast
    one = _greys(fit, slice(max(before.start, before.stop - ENDS), before.stop))
    other = _greys(fit, slice(after.start, min(after.stop, after.start + ENDS)))
    ground, sheet = (other - one) / contrast
    return float(ground), float(sheet), float(ground * one[1] / max(one[0], 1.0))


def _greys(fit: CurveFit, part: slice) -> FloatArray:
    """(2,) of ground and sheet."""
    ground = fit.cells[part, 1][fit.used[part]]
    contrast = fit.contrast[part][fit.used[part]]
    return np.array([np.median(ground), np.median(ground + contrast)])


def _shines(ground: float, sheet: float, shaded: float) -> bool:
    """Whether a ground shows through; a shadow's edge, which darkens both, does not."""
    through = abs(ground) > OTHER_GROUND and sheet / ground > SHINES_THROUGH
    return through and abs(sheet - shaded) > LIKE_SHADE * abs(ground)
