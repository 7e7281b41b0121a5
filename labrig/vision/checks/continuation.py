"""Follow the image beyond the sheet's stated end, to see whether the sheet continues.

A scale that is too small, or a length that is too short, puts the stated end on the middle of the
sheet, and perhaps under a roll. So the path follows what is there by small steps, through what may
hide the sheet, until there is plain background.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.checks.end_profile import profile_beyond
from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit
from labrig.vision.thresholds import (
    BACKGROUND_RUN_PX,
    CONTINUATION_RANGE_RATIO,
    CONTINUATION_SEEN_SHARE_MIN,
    CONTRAST_DEVIATION_MAX_RATIO,
)

FloatArray = npt.NDArray[np.float64]


def visible_continuation_px(fit: CurveFit, context: FitContext) -> float:
    """Return how far beyond the stated end the sheet is seen.

    0 where it ends, or nothing can tell.
    """
    shape, section = fit.shape, fit.section
    last = np.flatnonzero(fit.used)[-40:]
    if len(last) < 10:
        return 0.0
    contrast = float(np.median(fit.contrast[last]))
    ground = float(np.median(fit.cells[last, 1]))
    # what follows is no better seen than what went before
    half = float(section.half_width[-1])
    peak = contrast * math.erf(half / (math.sqrt(2) * section.blur))
    if abs(peak) < 1e-6:
        return 0.0
    ends = context.nodes_px(shape)[-5:]
    du, dv = ends[-1] - ends[0]

    def length_seen(bias_px: float) -> float:
        seen = profile_beyond(
            context.image.grey,
            context.image.smooth,
            context.mask,
            u=float(ends[-1, 0]),
            v=float(ends[-1, 1]),
            angle=math.atan2(dv, du),
            # pixels run down, the world up: curvature changes its sign
            bend=-0.5 * float(shape.k[-8]),
            steps=round(CONTINUATION_RANGE_RATIO * shape.basis.total_px),
            contrast=peak,
            half=half,
            blur=section.blur,
            bias_px=bias_px,
        )
        return _sheet_seen(seen[:, 0] / peak, (seen[:, 1] - ground) / contrast)

    # what crosses the end may lead the path along itself
    return max(length_seen(1.0), length_seen(0.0))


def _sheet_seen(ratio: FloatArray, flank: FloatArray) -> float:
    """Return the last place that looks like the sheet before a run of background."""
    ratio, flank = _steady(ratio), _steady(flank)
    sheet = np.abs(ratio - 1) < CONTRAST_DEVIATION_MAX_RATIO
    plain = (np.abs(ratio) < CONTRAST_DEVIATION_MAX_RATIO) & (
        np.abs(flank) < CONTRAST_DEVIATION_MAX_RATIO
    )
    run = 0
    for at, empty in enumerate(plain):
        run = run + 1 if empty else 0
        if run == BACKGROUND_RUN_PX:
            sheet, plain = sheet[: at + 1], plain[: at + 1]
            break
    places = np.flatnonzero(sheet)
    if not len(places):
        return 0.0
    known = (sheet | plain)[: places[-1] + 1]
    enough = sheet[: places[-1] + 1].sum() > CONTINUATION_SEEN_SHARE_MIN * max(1, known.sum())
    return float(places[-1] + 1) if enough else 0.0


def _steady(values: FloatArray) -> FloatArray:
    """Return the median of three neighbours: one pixel's noise is no sheet and no end."""
    padded = np.pad(values, 1, mode="edge")
    return np.asarray(np.median([padded[:-2], padded[1:-1], padded[2:]], axis=0))
