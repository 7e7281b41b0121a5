"""From a fit in pixels to a `NeutralCurve` in metres, with the uncertainty of both parts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.checks.acceptance import Verdict
from labrig.vision.checks.residual import offset_px
from labrig.vision.curve import NeutralCurve
from labrig.vision.curve.background_lines import BackgroundLine, hidden_by
from labrig.vision.fit.context import CrossSection, FitContext
from labrig.vision.fit.curve_fit import CurveFit, spread
from labrig.vision.thresholds import (
    BIAS_WARNED_PX,
    EXCESS_WIDTH_WARNED_PX,
    LINE_COVER_WARNED_SHARE,
    OFFSET_WARNED_PX,
)

FloatArray = npt.NDArray[np.float64]

SECTION_SIGMA_PX = 0.004
SIDE_FACE_SIGMA_RATIO = 0.06  # of what a side face adds beside the edge, when it has been taken off


def report(
    fit: CurveFit,
    context: FitContext,
    verdict: Verdict,
    excess_px: FloatArray | None = None,
    bias_px: FloatArray | None = None,
) -> NeutralCurve:
    """Return a fitted curve in metres; without arrays, with the reason, where it is refused.

    `excess_px` (nodes,): how much wider the sheet looks than it is, as `excess_width_px` has it;
    `bias_px` (nodes,): how far what touches the sheet may pull the curve; see `lateral_bias_px`.
    """
    warnings = context.image.warnings + verdict.warnings
    if verdict.why:
        return NeutralCurve(
            ok=False,
            why=verdict.why,
            warnings=warnings,
            covered=verdict.covered,
            residual_px=verdict.residual_px if np.isfinite(verdict.residual_px) else 0.0,
        )
    shape, ppm = fit.shape, context.optics.px_per_m
    none = np.zeros(len(shape.x))
    excess = none if excess_px is None else excess_px
    bias = none if bias_px is None else bias_px
    offset = offset_px(fit, context)
    deviation = verdict.join.deviation_px if verdict.join.doubtful else None
    covariance, modes = fit.covariance, shape.normal_modes()
    in_image = (
        spread(modes, covariance) ** 2
        + (excess / 2) ** 2
        + (none if deviation is None else deviation) ** 2
        + bias**2
        + offset**2
    )
    # offset in m, angle in rad, coefficients in 1/m
    unit = np.concatenate([[1 / ppm, 1.0], np.full(shape.basis.size - 2, ppm)])
    return NeutralCurve(
        ok=True,
        warnings=(*warnings, *_warnings(fit.section, excess, bias, offset)),
        s_m=shape.basis.s / ppm,
        x_m=shape.x / ppm,
        y_m=shape.y / ppm,
        curvature_per_m=shape.k * ppm,
        sigma_m=np.sqrt(in_image / ppm**2 + systematic_m(fit, context) ** 2),
        excess_px=excess,
        lateral_bias_px=bias,
        curvature_sigma_per_m=spread(shape.basis.curvature, covariance[2:, 2:]) * ppm,
        curvature_resolution_m=_resolution_px(fit, covariance) / ppm,
        points_px=context.nodes_px(shape),
        parameters=shape.parameters * unit,
        covariance=covariance * np.outer(unit, unit),
        normal_modes=modes / ppm / unit,
        free_length_m=shape.basis.free_px / ppm,
        thickness_m=2 * float(fit.section.half_width[0]) / ppm,
        polarity="bright" if context.sign > 0 else "dark",
        **_appearance(fit, verdict),
    )


def _appearance(fit: CurveFit, verdict: Verdict) -> dict[str, Any]:
    """Return how the sheet looks: the part of a curve that needs no calibration."""
    section, contrast = fit.section, fit.usual_contrast
    elongated = section.elongation.any()
    return {
        "covered": verdict.covered,
        "seen": np.append(fit.used, fit.used[-1]),
        "residual_px": verdict.residual_px,
        "contrast": contrast,
        "snr": contrast / fit.noise,
        "blur_px": section.blur,
        "elongation_width_px": 2 * float(section.half_width[-1]) if elongated else 0.0,
        "side_face_px": np.append(section.side_face, section.side_face[-1]),
        "side_face_share": section.side_face_share,
    }


def _warnings(
    section: CrossSection, excess: FloatArray, bias: FloatArray, offset: FloatArray
) -> Iterator[str]:
    """Yield what widens the credible band, or was left out; the arrays are (nodes,) pixels."""
    if excess.max() > EXCESS_WIDTH_WARNED_PX:
        yield (
            f"the sheet looks, or may look, up to {excess.max():.1f} pixels wider than it is "
            "thick; its face is seen with its edge, or it is out of focus; the curve may be off by "
            "half of that"
        )
    if bias.max() > BIAS_WARNED_PX:
        yield (
            "something touches the sheet on one side, such as its reflection, and may pull the "
            f"curve by up to {bias.max():.2f} pixels; the credible band holds it"
        )
    if offset.max() > OFFSET_WARNED_PX:
        yield (
            f"what looks like the sheet lies up to {offset.max():.1f} pixels beside the curve "
            "where it is not as thick or as smooth as a sheet; the credible band holds both"
        )
    share = section.side_face_share
    side_face = float(np.abs(section.side_face).max()) if share > 0 else 0.0
    if side_face * share > EXCESS_WIDTH_WARNED_PX:
        yield (
            f"the sheet's side face shows beside its edge, up to {side_face:.1f} pixels wide and "
            f"{share:.0%} as strong; it was separated from the edge and left out"
        )


def with_wires(
    curve: NeutralCurve, wires: Sequence[BackgroundLine], shape: tuple[int, int]
) -> NeutralCurve:
    """Return the curve with its left-out wires, and a warning where they hide some of it."""
    if not wires:
        return curve
    hidden = hidden_by(wires, shape)
    u, v = np.clip(np.round(curve.points_px).astype(int), 0, (shape[1] - 1, shape[0] - 1)).T
    share = float(hidden[v, u].mean())
    message = f"a wire lies along {share:.0%} of the sheet, or crosses it; it was left out there"
    more = (message,) if share > LINE_COVER_WARNED_SHARE else ()
    return replace(curve, warnings=curve.warnings + more, wires=tuple(wires))


def blamed(verdict: Verdict) -> Verdict:
    """Return the refusal with the wire named first, as its probable cause."""
    message = (
        "search failed: a wire, or something else that is straight, lies along the best path; take "
        f"it away, or mask it in the image. Without it: {verdict.why}"
    )
    return replace(verdict, why=message)


def systematic_m(fit: CurveFit, context: FitContext) -> FloatArray:
    """Return (nodes,) the part of sigma that no averaging removes, along the normal.

    Scale, rotation and origin of the calibration, and how well the band's template can be right.
    """
    shape, optics = fit.shape, context.optics
    x, y = shape.x / optics.px_per_m, shape.y / optics.px_per_m
    sine, cosine = np.sin(shape.phi), np.cos(shape.phi)
    stretch = (y * cosine - x * sine) * optics.px_per_mm_sigma / optics.px_per_mm
    turn = (x * cosine + y * sine) * optics.roll_sigma_rad
    shift = optics.origin_sigma_px / optics.px_per_m
    side_face = (
        np.append(fit.section.side_face, fit.section.side_face[-1])
        * fit.section.side_face_share
        * SIDE_FACE_SIGMA_RATIO
    )
    look = np.hypot(SECTION_SIGMA_PX, side_face) / optics.px_per_m
    return np.asarray(np.sqrt(stretch**2 + turn**2 + shift**2 + look**2))


def _resolution_px(fit: CurveFit, covariance: FloatArray) -> float:
    """Return length per effective degree of freedom of the curvature."""
    free = float(np.trace(covariance @ fit.normal)) - 2.0  # place and angle at the clamp
    return fit.shape.basis.free_px / max(free, 1.0)
