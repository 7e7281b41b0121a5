"""From a fit in pixels to a `NeutralCurve` in metres, with the uncertainty of both parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from labrig.vision.checks.acceptance import Verdict
from labrig.vision.checks.residual import offset_px
from labrig.vision.curve import NeutralCurve
from labrig.vision.curve.background_lines import BackgroundLine, hidden_by
from labrig.vision.fit.context import FitContext
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
    """Return the curve as others see it; empty, with the reason, when the self-check failed.

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
    covariance, modes = fit.covariance, shape.normal_modes()
    noise_px = spread(modes, covariance)
    rows = shape.basis.curvature
    # offset in m, angle in rad, coefficients in 1/m
    unit = np.concatenate([[1 / ppm, 1.0], np.full(shape.basis.size - 2, ppm)])
    excess = np.zeros(len(shape.x)) if excess_px is None else excess_px
    if excess.max() > EXCESS_WIDTH_WARNED_PX:
        message = (
            f"the sheet looks, or may look, up to {excess.max():.1f} pixels wider than it is "
            "thick; its face is seen with its edge, or it is out of focus; the curve may be off by "
            "half of that"
        )
        warnings = (*warnings, message)
    join = verdict.join
    aside = (
        join.deviation_px
        if join.doubtful and join.deviation_px is not None
        else np.zeros_like(excess)
    )
    pull = np.zeros_like(excess) if bias_px is None else bias_px
    if pull.max() > BIAS_WARNED_PX:
        message = (
            "something touches the sheet on one side, such as its reflection, and may pull the "
            f"curve by up to {pull.max():.2f} pixels; the credible band holds it"
        )
        warnings = (*warnings, message)
    beside = offset_px(fit, context)
    if beside.max() > OFFSET_WARNED_PX:
        message = (
            f"what looks like the sheet lies up to {beside.max():.1f} pixels beside the curve "
            "where it is not as thick or as smooth as a sheet; the credible band holds both"
        )
        warnings = (*warnings, message)
    side_face = (
        float(np.abs(fit.section.side_face).max()) if fit.section.side_face_share > 0 else 0.0
    )
    if side_face * fit.section.side_face_share > EXCESS_WIDTH_WARNED_PX:
        message = (
            f"the sheet's side face shows beside its edge, up to {side_face:.1f} pixels wide and "
            f"{fit.section.side_face_share:.0%} as strong; it was separated "
            "from the edge and left out"
        )
        warnings = (*warnings, message)
    contrast = fit.usual_contrast
    return NeutralCurve(
        ok=True,
        warnings=warnings,
        s_m=shape.basis.s / ppm,
        x_m=shape.x / ppm,
        y_m=shape.y / ppm,
        curvature_per_m=shape.k * ppm,
        sigma_m=np.sqrt(
            (noise_px**2 + (excess / 2) ** 2 + aside**2 + pull**2 + beside**2) / ppm**2
            + systematic_m(fit, context) ** 2
        ),
        excess_px=excess,
        lateral_bias_px=pull,
        curvature_sigma_per_m=spread(rows, covariance[2:, 2:]) * ppm,
        curvature_resolution_m=_resolution_px(fit, covariance) / ppm,
        points_px=context.nodes_px(shape),
        covered=verdict.covered,
        seen=np.append(fit.used, fit.used[-1]),
        residual_px=verdict.residual_px,
        contrast=contrast,
        snr=contrast / fit.noise,
        parameters=shape.parameters * unit,
        covariance=covariance * np.outer(unit, unit),
        normal_modes=modes / ppm / unit,
        polarity="bright" if context.sign > 0 else "dark",
        blur_px=fit.section.blur,
        free_length_m=shape.basis.free_px / ppm,
        thickness_m=2 * float(fit.section.half_width[0]) / ppm,
        elongation_width_px=2 * float(fit.section.half_width[-1])
        if fit.section.elongation.any()
        else 0.0,
        side_face_px=np.append(fit.section.side_face, fit.section.side_face[-1]),
        side_face_share=fit.section.side_face_share,
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
        "a wire, or something else that is straight, lies along the best path; take it away, "
        f"or mask it in the image. Without it: {verdict.why}"
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
