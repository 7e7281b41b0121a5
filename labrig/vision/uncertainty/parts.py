"""The parts of a curve's uncertainty: noise, and parts that averaging does not remove."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve
from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit, spread

FloatArray = npt.NDArray[np.float64]

# How well the band's template can be right. Of noiseless simulated images the modes of a curve are
# 0.001 to 0.004 pixels off, with a blur of 2 pixels 0.003 to 0.017, near the rolls and at the end;
# alike at all positions, so that they are worse known together than each by itself.
SECTION_SIGMA_PX = 0.004
SHARP_BLUR_PX = 0.8
SIDE_FACE_SIGMA_RATIO = 0.06  # of what a side face adds beside the edge, when it has been taken off


def sigma_m(
    fit: CurveFit, context: FitContext, covariance: FloatArray, widening_px: FloatArray
) -> FloatArray:
    """Return (nodes,) one standard deviation of the distance along the normal.

    `widening_px` (nodes,): what is added in quadrature, because something may pull the curve.
    """
    in_image = spread(fit.shape.normal_modes(), covariance) ** 2 + widening_px**2
    ppm = context.optics.px_per_m
    return np.asarray(np.sqrt(in_image / ppm**2 + systematic_m(fit, context) ** 2))


def systematic_m(fit: CurveFit, context: FitContext) -> FloatArray:
    """Return (nodes,) the part of sigma that no averaging removes, along the normal.

    Scale, rotation and origin of the calibration, and how well the band's template can be right.
    """
    shape, optics = fit.shape, context.optics
    x, y = shape.x / optics.px_per_m, shape.y / optics.px_per_m
    calibration = calibration_m(x, y, shape.phi, optics)
    side_face = (
        np.append(fit.section.side_face, fit.section.side_face[-1])
        * fit.section.side_face_share
        * SIDE_FACE_SIGMA_RATIO
    )
    look = np.hypot(section_sigma_px(fit.section.blur), side_face) / optics.px_per_m
    return np.asarray(np.hypot(calibration, look))


def section_sigma_px(blur_px: float) -> float:
    """Return how far a curve may be off because of how the strip looks with this blur."""
    return float(SECTION_SIGMA_PX * max(1.0, blur_px / SHARP_BLUR_PX) ** 2)


def systematic_sigma_px(curve: NeutralCurve) -> float:
    """Return the uncertainty of a curve in its image that no averaging of images removes."""
    faces = curve.side_face_px * curve.side_face_share * SIDE_FACE_SIGMA_RATIO
    face = float(np.sqrt(np.mean(faces**2))) if len(faces) else 0.0
    return float(np.hypot(section_sigma_px(curve.blur_px), face))


def calibration_m(x: FloatArray, y: FloatArray, phi: FloatArray, optics: Optics) -> FloatArray:
    """Return (nodes,) what scale, rotation and origin of the calibration leave, along the normal.

    `x`, `y` in m, `phi` the curve's direction in rad.
    """
    sine, cosine = np.sin(phi), np.cos(phi)
    stretch = (y * cosine - x * sine) * optics.px_per_mm_sigma / optics.px_per_mm
    turn = (x * cosine + y * sine) * optics.roll_sigma_rad
    shift = optics.origin_sigma_px / optics.px_per_m
    return np.asarray(np.sqrt(stretch**2 + turn**2 + shift**2))


def resolution_px(fit: CurveFit, covariance: FloatArray) -> float:
    """Return length per effective degree of freedom of the curvature."""
    free = float(np.trace(covariance @ fit.normal)) - 2.0  # place and angle at the clamp
    return fit.shape.basis.free_px / max(free, 1.0)
