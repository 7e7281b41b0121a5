"""Whether the sheet goes on beyond its stated end: the picture walked along from there.

A scale that is too small, or a length that is too short, puts the stated end on the middle of the
sheet, and perhaps under a roll. So the walk follows what is there by small steps, through what may
hide the sheet, until there is plain background.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision._jit import jit
from labrig.vision.fit.context import FitContext, MaskArray
from labrig.vision.fit.curve_fit import CurveFit

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]

FARTHEST = 0.25  # of the stated length
LIKE = 0.4  # how far from its usual contrast, as a share of it, the sheet may be
BACKGROUND_RUN_PX = 8  # so much of it in a row is the sheet's end
LEAST_SHARE = 0.7  # of what is seen, up to the farthest sheet: what goes on must go on


@jit
def _grey(image: MapArray, u: float, v: float) -> float:
    rows, columns = image.shape
    j, i = math.floor(u), math.floor(v)
    if i < 0 or j < 0 or i >= rows - 1 or j >= columns - 1:
        return np.nan
    a, b = u - j, v - i
    top = image[i, j] * (1 - a) + image[i, j + 1] * a
    low = image[i + 1, j] * (1 - a) + image[i + 1, j + 1] * a
    return float(top * (1 - b) + low * b)


@jit
def _walk(
    grey: MapArray,
    smooth: MapArray,
    mask: MaskArray,
    u: float,
    v: float,
    angle: float,
    bend: float,
    steps: int,
    contrast: float,
    half: float,
    blur: float,
    pulled: float,
) -> FloatArray:
    """(steps, 2): core minus flanks and the flanks' level, a pixel a step; NaN where hidden.

    `contrast`: the sheet's, with its sign; `half` its half width, `bend` its curvature per pixel;
    `pulled` 1: towards the middle of what is there, 0: straight on.
    """
    rows, columns = mask.shape
    out = np.full((steps, 2), np.nan)
    reach = 3.0 + half
    side = half + 2.5 * blur + 1.0
    for q in range(steps):
        angle += bend
        u += math.cos(angle)
        v += math.sin(angle)
        row, column = math.floor(v + 0.5), math.floor(u + 0.5)
        if row < 0 or column < 0 or row >= rows or column >= columns:
            break
        if mask[row, column] != 0:
            continue
        c, s = -math.sin(angle), math.cos(angle)
        floor = 0.5 * (
            _grey(smooth, u - reach * c, v - reach * s)
            + _grey(smooth, u + reach * c, v + reach * s)
        )
        # pull towards the middle of what is there, gently
        total, moment = 0.0, 0.0
        for i in range(-6, 7):
            d = i * reach / 6
            high = max(0.0, (_grey(smooth, u + d * c, v + d * s) - floor) / contrast)
            total += high
            moment += high * d
        if total > 0.3 * 2 * (half + blur) * 6 / reach:
            offset = moment / total
            u += 0.3 * pulled * offset * c
            v += 0.3 * pulled * offset * s
            angle += 0.02 * pulled * offset
        core = 0.0
        for i in range(-1, 2):
            core += _grey(grey, u + 0.5 * i * half * c, v + 0.5 * i * half * s) / 3
        flanks = 0.0
        for i in (-1, 1):
            for far in (side, side + 1.0):
                flanks += _grey(grey, u + i * far * c, v + i * far * s) / 4
        out[q, 0], out[q, 1] = core - flanks, flanks
    return out


def seen_beyond_px(fit: CurveFit, setting: FitContext) -> float:
    """How far beyond the stated end the sheet is seen; 0 where it ends, or nothing can tell."""
    shape, band = fit.shape, fit.band
    last = np.flatnonzero(fit.used)[-40:]
    if len(last) < 10:
        return 0.0
    contrast = float(np.median(fit.contrast[last]))
    ground = float(np.median(fit.cells[last, 1]))
    # what follows is no better seen than what went before
    half = float(band.half_width[-1])
    peak = contrast * math.erf(half / (math.sqrt(2) * band.blur))
    if abs(peak) < 1e-6:
        return 0.0
    ends = setting.nodes_px(shape)[-5:]
    du, dv = ends[-1] - ends[0]

    def walked(pulled: float) -> float:
        seen = _walk(
            setting.picture.grey,
            setting.picture.smooth,
            setting.mask,
            float(ends[-1, 0]),
            float(ends[-1, 1]),
            math.atan2(dv, du),
            # pixels run down, the world up: curvature changes its sign
            -0.5 * float(shape.k[-8]),
            round(FARTHEST * shape.basis.total_px),
            peak,
            half,
            band.blur,
            pulled,
        )
        return _sheet_seen(seen[:, 0] / peak, (seen[:, 1] - ground) / contrast)

    # what crosses the end pulls a walk along it
    return max(walked(1.0), walked(0.0))


def _sheet_seen(ratio: FloatArray, flank: FloatArray) -> float:
    """The last place that looks like the sheet before a run of background."""
    ratio, flank = _steady(ratio), _steady(flank)
    sheet = np.abs(ratio - 1) < LIKE
    plain = (np.abs(ratio) < LIKE) & (np.abs(flank) < LIKE)
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
    enough = sheet[: places[-1] + 1].sum() > LEAST_SHARE * max(1, known.sum())
    return float(places[-1] + 1) if enough else 0.0


def _steady(values: FloatArray) -> FloatArray:
    """The median of three neighbours: one pixel's noise is no sheet and no end."""
    padded = np.pad(values, 1, mode="edge")
    return np.asarray(np.median([padded[:-2], padded[1:-1], padded[2:]], axis=0))
