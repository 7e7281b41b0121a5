"""Estimate the lateral bias from something that touches the sheet, such as its reflection.

The fit's band has two sides alike. Light that one side has more of is taken for a displacement and
a blur; what those two do not explain of it tells that it is there, and so how far it pulls.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.context import FitContext, pixels_beside
from labrig.vision.fit.cross_section import templates
from labrig.vision.fit.curve_fit import CurveFit
from labrig.vision.thresholds import BIAS_GAIN_MIN, BIAS_RESIDUAL_MIN_RATIO, BIAS_USED_SHARE_MIN

FloatArray = npt.NDArray[np.float64]

PIECE_CELLS = 48
SECOND_IMAGE_OFFSETS_PX = (1.5, 2.5, 3.5, 4.5, 6.0)  # from the sheet to a second image of it


def lateral_bias_px(fit: CurveFit, context: FitContext) -> FloatArray:
    """Return (nodes,) how far what lies beside the sheet may have pulled the curve.

    0: nothing is seen.
    """
    used = fit.used
    starts = np.arange(0, len(used), PIECE_CELLS)
    squares = np.add.reduceat(np.where(used, fit.cells[:, 5], 0.0), starts)
    counts = np.add.reduceat(np.where(used, fit.cells[:, 6], 0.0), starts)
    level = np.sqrt(squares / np.maximum(counts, 1.0))
    share = np.add.reduceat(used.astype(float), starts) / PIECE_CELLS
    doubtful = (level > BIAS_RESIDUAL_MIN_RATIO * context.image.noise) & (
        share > BIAS_USED_SHARE_MIN
    )
    if not doubtful.any():
        return np.zeros(len(used) + 1)
    pixels = pixels_beside(fit.shape, context, fit.section.reach)
    pull = np.zeros(len(starts))
    for i in np.flatnonzero(doubtful):
        cells = slice(int(starts[i]), min(int(starts[i]) + PIECE_CELLS, len(used)))
        pull[i] = _bias_px(fit, cells, pixels)
    middles = starts + PIECE_CELLS / 2
    return np.asarray(np.interp(np.arange(len(used) + 1), middles, pull))


def _bias_px(
    fit: CurveFit, cells: slice, pixels: tuple[FloatArray, FloatArray, npt.NDArray[np.int64]]
) -> float:
    """Return how far the likeliest second image beside some cells pulls them.

    0 where there is none.
    """
    value, distance, first = pixels
    part = slice(int(first[cells.start]), int(first[cells.stop]))
    kept = np.repeat(fit.used[cells], np.diff(first[cells.start : cells.stop + 1]))
    y, d = value[part], distance[part]
    plain, slope, sharpness = _bands(fit, cells, d, first)
    own = np.stack([np.ones_like(d), d, plain, sharpness, slope], axis=1)[kept]
    beside = [
        _bands(fit, cells, d - at, first)[0]
        for at in (*SECOND_IMAGE_OFFSETS_PX, *(-a for a in SECOND_IMAGE_OFFSETS_PX))
    ]
    second = np.stack(beside, axis=1)[kept]
    q, r = np.linalg.qr(own)
    led = np.linalg.solve(r, q.T @ np.column_stack([second, y[kept]]))
    alone = second - own @ led[:, :-1]
    left = y[kept] - own @ led[:, -1]
    size = np.maximum((alone**2).sum(axis=0), 1e-9)
    much = (alone * left[:, None]).sum(axis=0) / size
    noise = float(left.std())
    gain = much**2 * size / noise**2
    contrast = float(led[2, -1])
    # it is light that adds to the sheet's, and less than the sheet
    gain[(much * contrast <= 0) | (np.abs(much) > abs(contrast))] = 0.0
    best = int(np.argmax(gain))
    if gain[best] < BIAS_GAIN_MIN:
        return 0.0
    return float(abs(much[best] * led[4, best] / contrast))


def _bands(
    fit: CurveFit, cells: slice, distance: FloatArray, first: npt.NDArray[np.int64]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the sheet's band at distances from its middle, its slope, and its change with blur."""
    section = fit.section
    own = first[cells.start : cells.stop + 1] - first[cells.start]
    return templates(
        distance,
        own,
        section.half_width[cells],
        section.blur,
        np.zeros(len(own) - 1),
        section.side_face[cells],
        section.side_face_share,
    )
