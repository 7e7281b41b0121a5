"""Compiled kernel that follows the sheet beyond its stated end, one pixel a step."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]
MaskArray = npt.NDArray[np.uint8]


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
def profile_beyond(
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
    bias_px: float,
) -> FloatArray:
    """Return (steps, 2): core minus flanks and the flanks' level, a pixel a step; NaN where hidden.

    `contrast`: the sheet's, with its sign; `half` its half width, `bend` its curvature per pixel;
    `bias_px` 1: towards the middle of what is there, 0: straight on.
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
            u += 0.3 * bias_px * offset * c
            v += 0.3 * bias_px * offset * s
            angle += 0.02 * bias_px * offset
        core = 0.0
        for i in range(-1, 2):
            core += _grey(grey, u + 0.5 * i * half * c, v + 0.5 * i * half * s) / 3
        flanks = 0.0
        for i in (-1, 1):
            for far in (side, side + 1.0):
                flanks += _grey(grey, u + i * far * c, v + i * far * s) / 4
        out[q, 0], out[q, 1] = core - flanks, flanks
    return out
