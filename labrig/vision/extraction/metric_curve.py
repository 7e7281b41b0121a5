"""Convert a checked curve in pixels to a `NeutralCurve` in metres, with its uncertainty."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.checks.contract import CheckStage
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.checks.verdict import StageVerdict, Verdict, judge
from labrig.vision.curve import NeutralCurve
from labrig.vision.fit.curve_fit import spread
from labrig.vision.uncertainty.parts import resolution_px, sigma_m

FloatArray = npt.NDArray[np.float64]


def reported(seen: SeenCurve, verdict: Verdict) -> NeutralCurve:
    """Return a chosen curve in metres, or why it is refused after all.

    `verdict`: that on it as a candidate.
    """
    if verdict.why:
        return refused(seen, verdict, verdict)
    chosen = judge(seen, CheckStage.CHOSEN)
    if chosen.why:
        return refused(seen, verdict, chosen)
    context, covariance = seen.context, seen.fit.covariance
    widening_px = np.hypot(verdict.widening_px, chosen.widening_px)
    sigma = sigma_m(seen.fit, context, covariance, widening_px)
    known = seen.with_sigma(sigma * context.optics.px_per_m)
    last = judge(known, CheckStage.UNCERTAINTY)
    if last.why:
        return refused(seen, verdict, last)
    sigma = np.hypot(sigma, last.widening_px / context.optics.px_per_m)
    warnings = context.image.warnings + verdict.warnings + chosen.warnings + last.warnings
    return _in_metres(seen, verdict, covariance, sigma, warnings)


def refused(seen: SeenCurve, verdict: Verdict, judgement: StageVerdict) -> NeutralCurve:
    """Return the reason of a judgement, with what the verdict measured."""
    return NeutralCurve(
        ok=False,
        why=judgement.why,
        refused_at_px=judgement.refused_at_px,
        warnings=seen.context.image.warnings + verdict.warnings,
        covered=verdict.covered,
        residual_px=verdict.residual_px if np.isfinite(verdict.residual_px) else 0.0,
    )


def _in_metres(
    seen: SeenCurve,
    verdict: Verdict,
    covariance: FloatArray,
    sigma: FloatArray,
    warnings: tuple[str, ...],
) -> NeutralCurve:
    shape, ppm = seen.fit.shape, seen.context.optics.px_per_m
    # offset in m, angle in rad, coefficients in 1/m
    unit = np.concatenate([[1 / ppm, 1.0], np.full(shape.basis.size - 2, ppm)])
    return NeutralCurve(
        ok=True,
        warnings=warnings,
        s_m=shape.basis.s / ppm,
        x_m=shape.x / ppm,
        y_m=shape.y / ppm,
        curvature_per_m=shape.k * ppm,
        sigma_m=sigma,
        excess_px=seen.along(seen.excess_px),
        lateral_bias_px=seen.along(seen.lateral_bias_px),
        curvature_sigma_per_m=spread(shape.basis.curvature, covariance[2:, 2:]) * ppm,
        curvature_resolution_m=resolution_px(seen.fit, covariance) / ppm,
        points_px=seen.context.nodes_px(shape),
        parameters=shape.parameters * unit,
        covariance=covariance * np.outer(unit, unit),
        normal_modes=shape.normal_modes() / ppm / unit,
        free_length_m=shape.basis.free_px / ppm,
        elongation_straight=not shape.basis.rest_bends,
        thickness_m=2 * float(seen.fit.section.half_width[0]) / ppm,
        polarity="bright" if seen.context.sign > 0 else "dark",
        wires=seen.wires,
        **_appearance(seen, verdict),
    )


def _appearance(seen: SeenCurve, verdict: Verdict) -> dict[str, Any]:
    """Return how the sheet looks: the part of a curve that needs no calibration."""
    fit = seen.fit
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
