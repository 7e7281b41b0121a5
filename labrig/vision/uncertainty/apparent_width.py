"""Compare the sheet's apparent width with its thickness: a wider sheet has something beside it.

In a silhouette the sheet's face is as dark as its edge, and no fit can tell which part is which.
The curve is then good to half the excess only; that goes into its band and into a warning.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.context import CrossSection, FitContext, measure_along
from labrig.vision.fit.curve_fit import CurveFit, ridge_points
from labrig.vision.image.image import SMOOTHING_PX
from labrig.vision.thresholds import (
    BLUR_SUSPICIOUS_PX,
    EXCESS_WIDTH_CORRUPTED_PX,
    EXCESS_WIDTH_GAIN_MIN,
    EXCESS_WIDTH_LOCAL_MAX_PX,
    UNHIDDEN_SHARE_MIN,
    WIDTH_TOLERANCE_PX,
)

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

SMOOTH_NODES = 12
EXTRA_WIDTHS_PX = (1.0, 2.0, 3.0, 4.5, 6.0, 8.0)


def excess_width_px(fit: CurveFit, context: FitContext) -> FloatArray:
    """Return (nodes,) the visible width beyond that of the sheet's thickness, 0 where usual."""
    blur, wider = _sharper_section(fit, context)
    half = np.append(fit.section.half_width, fit.section.half_width[-1])
    reach = np.full(len(half), round(2 * float(half.max()) + 10))
    offset, _, width = ridge_points(fit.shape, context, reach)
    blur = float(np.hypot(blur, SMOOTHING_PX))
    usual = _visible_widths(fit.section, blur)
    usual = np.append(usual, usual[-1])
    clear = fit.used & (fit.present > UNHIDDEN_SHARE_MIN)
    good = np.isfinite(width) & (np.abs(offset) < width) & np.append(clear, clear[-1])
    excess = np.where(good, width - usual, 0.0)
    padded = np.pad(excess, SMOOTH_NODES, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * SMOOTH_NODES + 1)
    return np.asarray(np.maximum(np.median(windows, axis=1) - WIDTH_TOLERANCE_PX, wider))


def something_lies_along(excess_px: FloatArray, fit: CurveFit) -> bool:
    """Return whether the sheet looks much wider in one place only.

    A wire beside it, not its own face.
    """
    thickness = 2 * float(fit.section.half_width[0])
    much = max(EXCESS_WIDTH_LOCAL_MAX_PX, thickness)
    return bool(excess_px.max() > much and np.median(excess_px) < 1.0)


def corrupted_cells(excess_px: FloatArray) -> BoolArray:
    """Return (cells,) where something lies along the sheet, with what it may have biased beside."""
    wide = (excess_px[1:] > EXCESS_WIDTH_CORRUPTED_PX) | (
        excess_px[:-1] > EXCESS_WIDTH_CORRUPTED_PX
    )
    return np.convolve(wide, np.ones(2 * SMOOTH_NODES + 1), mode="same") > 0.5


def _sharper_section(fit: CurveFit, context: FitContext) -> tuple[float, float]:
    """Return the blur, and the excess width of the whole sheet where that fits better.

    A wide band with sharp edges and a thin one with much blur differ in their flanks only.
    """
    section = fit.section
    if section.blur < BLUR_SUSPICIOUS_PX:
        return section.blur, 0.0
    best, blur, wider = (
        _residual_squares(fit, context, section) - EXCESS_WIDTH_GAIN_MIN,
        section.blur,
        0.0,
    )
    for extra in EXTRA_WIDTHS_PX:
        half = np.where(section.elongation, section.half_width, section.half_width + extra / 2)
        thin, wide = 2 * section.half_width[0], 2 * section.half_width[0] + extra
        spread = section.blur**2 + (thin**2 - wide**2) / 12  # of the same second moment
        sharper = float(np.sqrt(max(spread, 0.5**2)))
        residual_squares = _residual_squares(
            fit, context, replace(section, half_width=half, blur=sharper)
        )
        if residual_squares < best:
            best, blur, wider = residual_squares, sharper, extra
    return blur, wider


def _residual_squares(fit: CurveFit, context: FitContext, section: CrossSection) -> float:
    cells, _ = measure_along(fit.shape, context, section, 20 * fit.noise, fit.used)
    return float(cells[fit.used & ~section.elongation, 5].sum()) / fit.noise**2


def _visible_widths(section: CrossSection, blur: float) -> FloatArray:
    """Return (cells,) full width at half height of a blurred band with its face."""
    sizes_px = np.round(
        np.stack([section.half_width, np.abs(section.side_face) * (section.side_face_share > 0)]), 1
    )
    kinds, which = np.unique(sizes_px, axis=1, return_inverse=True)
    widths = [
        _visible_width(half, side_face, section.side_face_share, blur)
        for half, side_face in kinds.T
    ]
    return np.asarray(widths)[which.ravel()]


def _visible_width(half: float, side_face: float, share: float, blur: float) -> float:
    from scipy.special import ndtr

    d = np.arange(-half - 4 * blur, half + side_face + 4 * blur, 0.05)
    profile = ndtr((d + half) / blur) - ndtr((d - half) / blur)
    profile += share * (ndtr((d - half) / blur) - ndtr((d - half - side_face) / blur))
    return 0.05 * float(np.count_nonzero(profile > 0.5 * profile.max()))
