"""From a fit in pixels to a `NeutralCurve` in metres, with the uncertainty of both parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from labrig.vision.checks.acceptance import Verdict
from labrig.vision.checks.residual import beside_px
from labrig.vision.curve import NeutralCurve
from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit, spread
from labrig.vision.search.straight_lines import BackgroundLine, hidden_by

FloatArray = npt.NDArray[np.float64]

LOOK_SIGMA_PX = 0.004
FACE_SIGMA = 0.06  # of what a far face adds beside the edge, when it has been taken off
LEAST_EXCESS_PX = 0.5
LEAST_PULL_PX = 0.05
LEAST_BESIDE_PX = 0.3
LEAST_TOLD = 0.02  # of the sheet hidden by wires


def report(
    fit: CurveFit,
    setting: FitContext,
    verdict: Verdict,
    excess_px: FloatArray | None = None,
    pulled: FloatArray | None = None,
) -> NeutralCurve:
    """The curve as others see it; empty, with the reason, when the self-check failed.

    `excess_px` (nodes,): how much wider the sheet looks than it is, as `excess_width_px` has it;
    `pulled` (nodes,): how far what touches it may pull the curve, as `pulled_px` has it.
    """
    warnings = setting.picture.warnings + verdict.warnings
    if verdict.why:
        return NeutralCurve(
            ok=False,
            why=verdict.why,
            warnings=warnings,
            covered=verdict.covered,
            residual_px=verdict.residual_px if np.isfinite(verdict.residual_px) else 0.0,
        )
    shape, ppm = fit.shape, setting.optics.px_per_m
    covariance, modes = fit.covariance, shape.normal_modes()
    noise_px = spread(modes, covariance)
    rows = shape.basis.curvature
    # offset in m, angle in rad, coefficients in 1/m
    unit = np.concatenate([[1 / ppm, 1.0], np.full(shape.basis.size - 2, ppm)])
    excess = np.zeros(len(shape.x)) if excess_px is None else excess_px
    if excess.max() > LEAST_EXCESS_PX:
        said = (
            f"the sheet looks, or may look, up to {excess.max():.1f} pixels wider than it is "
            "thick; its face is seen with its edge, or it is out of focus; the curve may be off by "
            "half of that"
        )
        warnings = (*warnings, said)
    join = verdict.join
    aside = join.aside_px if join.doubtful and join.aside_px is not None else np.zeros_like(excess)
    pull = np.zeros_like(excess) if pulled is None else pulled
    if pull.max() > LEAST_PULL_PX:
        said = (
            "something touches the sheet on one side, such as its reflection, and may pull the "
            f"curve by up to {pull.max():.2f} pixels; the band holds it"
        )
        warnings = (*warnings, said)
    beside = beside_px(fit, setting)
    if beside.max() > LEAST_BESIDE_PX:
        said = (
            f"what looks like the sheet lies up to {beside.max():.1f} pixels beside the curve "
            "where it is not as thick or as smooth as a sheet; the band holds both"
        )
        warnings = (*warnings, said)
    face = float(np.abs(fit.band.face).max()) if fit.band.face_share > 0 else 0.0
    if face * fit.band.face_share > LEAST_EXCESS_PX:
        said = (
            f"the sheet's far face shows beside its edge, up to {face:.1f} pixels wide and "
            f"{fit.band.face_share:.0%} as strong; it was told from the edge and left out"
        )
        warnings = (*warnings, said)
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
            + systematic_m(fit, setting) ** 2
        ),
        excess_px=excess,
        pull_px=pull,
        curvature_sigma_per_m=spread(rows, covariance[2:, 2:]) * ppm,
        curvature_resolution_m=_resolution_px(fit, covariance) / ppm,
        points_px=setting.nodes_px(shape),
        covered=verdict.covered,
        seen=np.append(fit.used, fit.used[-1]),
        residual_px=verdict.residual_px,
        contrast=contrast,
        snr=contrast / fit.noise,
        parameters=shape.parameters * unit,
        covariance=covariance * np.outer(unit, unit),
        normal_modes=modes / ppm / unit,
        polarity="bright" if setting.sign > 0 else "dark",
        blur_px=fit.band.blur,
        free_length_m=shape.basis.free_px / ppm,
        thickness_m=2 * float(fit.band.half_width[0]) / ppm,
        elongation_width_px=2 * float(fit.band.half_width[-1])
        if fit.band.elongation.any()
        else 0.0,
        face_px=np.append(fit.band.face, fit.band.face[-1]),
        face_share=fit.band.face_share,
    )


def with_wires(
    curve: NeutralCurve, wires: Sequence[BackgroundLine], shape: tuple[int, int]
) -> NeutralCurve:
    """The curve with the wires that were left out, and a warning where they hide some of it."""
    if not wires:
        return curve
    hidden = hidden_by(wires, shape)
    u, v = np.clip(np.round(curve.points_px).astype(int), 0, (shape[1] - 1, shape[0] - 1)).T
    share = float(hidden[v, u].mean())
    said = f"a wire lies along {share:.0%} of the sheet, or crosses it; it was left out there"
    more = (said,) if share > LEAST_TOLD else ()
    return replace(curve, warnings=curve.warnings + more, wires=tuple(wires))


def blamed(verdict: Verdict) -> Verdict:
    """Why not, with the wire before all that would not be wrong without it."""
    said = (
        "a wire, or something else that is straight, lies along the best path; take it away, "
        f"or mask it in the picture. Without it: {verdict.why}"
    )
    return replace(verdict, why=said)


def systematic_m(fit: CurveFit, setting: FitContext) -> FloatArray:
    """(nodes,) the part of sigma that no averaging removes, along the normal.

    Scale, rotation and origin of the calibration, and how well the band's template can be right.
    """
    shape, optics = fit.shape, setting.optics
    x, y = shape.x / optics.px_per_m, shape.y / optics.px_per_m
    sine, cosine = np.sin(shape.phi), np.cos(shape.phi)
    stretch = (y * cosine - x * sine) * optics.px_per_mm_sigma / optics.px_per_mm
    turn = (x * cosine + y * sine) * optics.roll_sigma_rad
    shift = optics.origin_sigma_px / optics.px_per_m
    face = np.append(fit.band.face, fit.band.face[-1]) * fit.band.face_share * FACE_SIGMA
    look = np.hypot(LOOK_SIGMA_PX, face) / optics.px_per_m
    return np.asarray(np.sqrt(stretch**2 + turn**2 + shift**2 + look**2))


def _resolution_px(fit: CurveFit, covariance: FloatArray) -> float:
    """Length per effective degree of freedom of the curvature."""
    free = float(np.trace(covariance @ fit.normal)) - 2.0  # place and angle at the clamp
    return fit.shape.basis.free_px / max(free, 1.0)
