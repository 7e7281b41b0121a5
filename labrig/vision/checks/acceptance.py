"""Whether a fitted curve is the sheet: reasons to refuse it, and warnings, as sentences."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.checks.continuation import visible_continuation_px
from labrig.vision.checks.gap_continuity import GapJoin, worst_join
from labrig.vision.checks.neighbouring_structure import is_an_edge, runs_beside_opposite
from labrig.vision.checks.sheet_end import SheetEnd, missing_end_px, missing_start_px
from labrig.vision.curve import smallness
from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit, seen_start, spread
from labrig.vision.thresholds import (
    CLAMP_KINK_SIGMA_RAD,
    COVERED_SHARE_MIN,
    COVERED_SHARE_WARNED,
    CURVATURE_MAX_PER_M,
    CURVATURE_REFUSED_RATIO,
    END_IN_PLACE_CHI2,
    END_IN_PLACE_MAX_PX,
    END_OFFSET_WARNED_PX,
    FULLY_SEEN_SHARE,
    GAP_CHI2_MAX,
    HIDDEN_SIGMA_MAX_PX,
    IN_VIEW_SHARE_MIN,
    LENGTH_ERROR_MAX_PX,
    LENGTH_ERROR_MAX_RATIO,
    RESIDUAL_MAX_PX,
    SATURATED_SHARE_WARNED,
    SNR_MIN,
    START_CHI2_MAX,
    START_COVERED_SHARE_MIN,
    UNSEEN_END_MAX_PX,
)

BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """`why` is empty when the curve passes."""

    why: str
    warnings: tuple[str, ...]
    covered: float
    residual_px: float
    worth: float  # to choose between candidates: how much of the image the curve explains
    join: GapJoin  # the least likely one of what is seen before and beyond hidden stretches


def check_curve(
    fit: CurveFit,
    context: FitContext,
    sheet_end: SheetEnd,
    *,
    followed: bool = False,
    beside: bool = True,
) -> Verdict:
    """Return all tests of a fitted curve.

    `followed`: from the image before, whose end and surroundings were checked. `beside`: check
    what lies beside the curve.
    """
    covered = float(fit.used[2:-2].mean())
    residual = smooth_residual_px(fit)
    strength = np.abs(fit.contrast[fit.used]) / context.image.noise
    worth = float(np.minimum(strength, 50).sum() / len(fit.used)) if fit.used.any() else 0.0
    join = worst_join(fit, context)
    found = [
        *_faults(fit, context, sheet_end, residual, followed, beside),
        _broken(join, sheet_end),
    ]
    faults = [fault for fault in found if fault]
    return Verdict(
        why=faults[0] if faults else "",
        warnings=tuple(_warnings(context, sheet_end, covered, join)),
        covered=covered,
        residual_px=residual,
        worth=worth * (0.3 if faults else 1.0),
        join=join,
    )


def smooth_residual_px(fit: CurveFit) -> float:
    """Return RMS distance between the curve and the sheet as measured in pieces of 15 pixels."""
    offset, sigma = fit.offsets_px
    weight = np.where(fit.used, 1 / np.maximum(sigma, 1e-6) ** 2, 0.0)
    box = np.ones(15)
    total = np.convolve(weight, box, mode="same")
    mean = np.convolve(weight * np.clip(offset, -3, 3), box, mode="same")
    seen = fit.used & (total > 0)
    if not seen.any():
        return float("inf")
    return float(np.sqrt(np.mean((mean[seen] / total[seen]) ** 2)))


def _faults(
    fit: CurveFit,
    context: FitContext,
    sheet_end: SheetEnd,
    residual: float,
    followed: bool,
    beside: bool,
) -> list[str]:
    shape, optics = fit.shape, context.optics
    length_mm = shape.basis.total_px / optics.px_per_mm
    end_u, end_v = context.nodes_px(shape)[-1]
    rows, columns = context.image.grey.shape
    near = 8 if sheet_end.out_of_sight else 3
    inside = near < end_u < columns - near - 1 and near < end_v < rows - near - 1
    snr = fit.usual_contrast / fit.noise
    start = max(20, len(fit.used) // 8)
    steepest = float(np.abs(shape.k).max()) * optics.px_per_m
    start_px, start_rad, start_chi2 = _start_beside(fit, context)
    allowed = max(LENGTH_ERROR_MAX_PX, LENGTH_ERROR_MAX_RATIO * shape.basis.total_px)
    sheet_end = sheet_end if followed else _further(sheet_end, fit, context, allowed)
    tip_px = sheet_end.beyond_px if sheet_end.beyond_px is not None else -missing_end_px(fit)
    in_view = float(fit.in_view[2:-2].mean())
    seen = _share(fit.used, fit.in_view, slice(2, -2))
    whole = fit.used.mean() > FULLY_SEEN_SHARE
    loose = 0.0 if whole else float(spread(shape.normal_modes(), fit.cautious_covariance).max())
    late = missing_start_px(fit, context)
    most_residual = RESIDUAL_MAX_PX * max(1.0, 2 * float(fit.section.half_width[0]) / 3)
    return [
        "check of the end failed: "
        f"the sheet leaves the image: its end, {length_mm:.1f} mm along the best path, is "
        "outside or at the border; move the camera or check clamp_px, px_per_mm and the sheet's "
        "length."
        if not inside
        else "",
        "check of hidden parts failed: "
        f"rolls or wires hide all but {in_view:.0%} of the best path; take away what hides the "
        "sheet."
        if in_view < IN_VIEW_SHARE_MIN
        else "",
        "search failed: "
        f"no sheet was found that starts at the clamp: only {seen:.0%} of the best path looks "
        "like one; check the image, clamp_px and the sheet's length."
        if seen < COVERED_SHARE_MIN
        else "",
        "check of the start failed: no sheet was found at the clamp: the first "
        f"{start} pixels of the best path do not look like one; check clamp_px."
        if _share(fit.used, fit.in_view, slice(2, start)) < START_COVERED_SHARE_MIN
        and not _shows(fit, context, start)
        else "",
        "check of the start failed: "
        f"there is plain background on the first {late:.0f} pixels of the best path; the "
        "sheet does not begin at the clamp, or something else was followed; check clamp_px."
        if late > 0
        else "",
        "check of the contrast failed: "
        f"the contrast is too low: {snr:.1f} times the noise, at least {SNR_MIN:g} is needed."
        if snr < SNR_MIN
        else "",
        "check of hidden parts failed: "
        f"where the sheet is hidden or unclear it is known to ±{loose:.1f} pixels only; make more "
        "of it visible."
        if loose > HIDDEN_SIGMA_MAX_PX
        else "",
        "check of the fit failed: "
        f"the best curve misses the sheet by {residual:.2f} pixels; something else was followed."
        if residual > most_residual
        else "",
        "check of the start failed: "
        f"what was followed leads {start_px:.1f} pixels and {start_rad:.2f} rad beside the clamp; "
        "check clamp_px and clamp_angle_rad."
        if start_chi2 > START_CHI2_MAX
        else "",
        "check of the fit failed: "
        f"the best curve bends by {steepest:.0f} per m, more than a sheet can."
        if steepest > CURVATURE_REFUSED_RATIO * CURVATURE_MAX_PER_M * smallness(length_mm / 1000)
        else "",
        "check of the surroundings failed: "
        "what was followed is the edge of something wide, not a sheet; check clamp_px."
        if beside and not followed and is_an_edge(fit, context)
        else "",
        "check of the surroundings failed: "
        "what was followed runs beside something stronger of the opposite brightness; it is a "
        "shadow or an edge, not the sheet; check polarity and clamp_px."
        if beside and runs_beside_opposite(fit, context)
        else "",
        f"check of the end failed: the sheet ends {'at least ' if sheet_end.at_least else ''}"
        f"{abs(tip_px) / optics.px_per_mm:.1f} mm {'after' if tip_px > 0 else 'before'} the "
        f"stated {length_mm:.1f} mm; px_per_mm or the sheet's length is wrong."
        if abs(tip_px) > (UNSEEN_END_MAX_PX if sheet_end.at_least else allowed)
        else "",
    ]


def _broken(join: GapJoin, sheet_end: SheetEnd) -> str:
    in_place = sheet_end.beyond_px is not None and abs(sheet_end.beyond_px) < END_IN_PLACE_MAX_PX
    if join.chi2 <= GAP_CHI2_MAX + (END_IN_PLACE_CHI2 if in_place else 0.0):
        return ""
    return (
        "check of hidden parts failed: "
        f"what is seen beyond a hidden stretch is {abs(join.offset_px):.1f} pixels and "
        f"{abs(join.turn_rad):.2f} rad beside where the sheet before it leads; something else "
        "was followed there; make more of the sheet visible."
    )


def _start_beside(fit: CurveFit, context: FitContext) -> tuple[float, float, float]:
    """Return offset and angle of what is seen, led on to the clamp, and their chi square there."""
    beside, covariance = seen_start(fit, context)
    clamp = np.diag(context.prior**2 + np.array([0.0, CLAMP_KINK_SIGMA_RAD**2]))
    chi2 = beside @ np.linalg.solve(covariance + clamp, beside)
    return float(beside[0]), float(beside[1]), float(chi2)


def _share(used: BoolArray, in_view: BoolArray, part: slice) -> float:
    """Return of what can be seen there, how much looks like the sheet; 1 where all is hidden."""
    return float(used[part].sum() / in_view[part].sum()) if in_view[part].any() else 1.0


def _further(sheet_end: SheetEnd, fit: CurveFit, context: FitContext, allowed: float) -> SheetEnd:
    """Return the end as it is seen, or that the sheet continues far beyond where it should end."""
    if sheet_end.at_least or (
        sheet_end.beyond_px is not None and abs(sheet_end.beyond_px) > allowed
    ):
        return sheet_end
    beyond = visible_continuation_px(fit, context)
    return SheetEnd(beyond, at_least=True) if beyond > allowed else sheet_end


def _shows(fit: CurveFit, context: FitContext, start: int) -> bool:
    """Return whether something of the sheet's brightness, but not its width, leaves the clamp."""
    contrast = context.sign * fit.contrast
    usual = float(np.median(contrast[fit.used])) if fit.used.any() else np.inf
    return bool(np.mean(contrast[2:start] > 0.4 * usual) > 0.75)


def _warnings(context: FitContext, sheet_end: SheetEnd, covered: float, join: GapJoin) -> list[str]:
    out = []
    if covered < COVERED_SHARE_WARNED:
        out.append(f"the sheet is hidden or unclear on {1 - covered:.0%} of its length")
    if join.doubtful:
        out.append(
            f"what is seen beyond a hidden stretch is {abs(join.offset_px):.1f} pixels beside "
            "where the sheet before it leads; the credible band holds both"
        )
    if context.sign > 0 and context.image.clipped > SATURATED_SHARE_WARNED:
        out.append("parts of the image are saturated")
    beyond_px = sheet_end.beyond_px
    if beyond_px is not None and abs(beyond_px) > END_OFFSET_WARNED_PX:
        out.append(
            f"the sheet's end is seen {beyond_px / context.optics.px_per_mm:+.2f} mm from "
            "where length and scale put it"
        )
    return out
