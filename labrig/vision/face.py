"""The far face: an 11 mm wide sheet seen a little from the side shows a grey stripe at its edge.

Taken for a part of the edge it would pull the curve to its side; so where the pixels want a
plateau on one side of the band, the band gets one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from labrig.vision.fit import Fit
from labrig.vision.setting import Band, Setting, look

FloatArray = npt.NDArray[np.float64]

WIDTHS_PX = (1.5, 3.0, 5.0, 8.0)
LEAST_GAIN = 25.0  # twice a log-likelihood, over a window: what a plateau must explain
LEAST_SHARE = 0.08
SMOOTH_CELLS = 16


def with_face(fit: Fit, setting: Setting, *, hint_only: bool = True) -> Band | None:
    """The fit's band with the far face where one is seen; None when there is none.

    `hint_only`: try one width first, and the others only when it explains something.
    """
    plain = _cost(fit, setting, 0.0) if fit.band.face.any() else _total(fit, fit.cells)
    hints = [_cost(fit, setting, width) for width in (4.0, -4.0)]
    if hint_only and np.mean(plain - np.minimum(*hints) > LEAST_GAIN) < LEAST_SHARE:
        return None
    widths = np.array([0.0, *WIDTHS_PX, *(-w for w in WIDTHS_PX)])
    costs = np.array([plain] + [_cost(fit, setting, w) for w in widths[1:]])
    costs[0] -= LEAST_GAIN  # without a face unless it explains enough
    best = widths[np.argmin(costs, axis=0)]
    if np.mean(best != 0) < LEAST_SHARE:
        return None
    return replace(fit.band, face=_steady(best))


def _cost(fit: Fit, setting: Setting, width: float) -> FloatArray:
    """(cells,) the squared residuals around each cell with a face of one width everywhere."""
    face = np.full(len(fit.used), width)
    cells, _ = look(fit.shape, setting, replace(fit.band, face=face), fit.noise, fit.used)
    return _total(fit, cells)


def _total(fit: Fit, cells: FloatArray) -> FloatArray:
    # what the robust weights leave out must cost, or a band that fits nothing would win
    lost = np.maximum(0.0, fit.cells[:, 6] + 2 - cells[:, 6]) * 3
    single = np.where(fit.used, cells[:, 5] / fit.noise**2 + lost, 0.0)
    return np.convolve(single, np.ones(2 * SMOOTH_CELLS + 1), mode="same")


def _steady(widths: FloatArray) -> FloatArray:
    """A face comes and goes slowly along the sheet."""
    half = SMOOTH_CELLS
    padded = np.pad(widths, half, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1)
    return np.asarray(np.median(windows, axis=1))
