"""Report a curve between two edges: the reason of a refusal, or the curve in metres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.checks.contract import CurveFinding, Pixel
from labrig.vision.checks.seen_outline import OutlineContext, SeenOutline
from labrig.vision.checks.verdict import judge_outline
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extraction.outline_shape import Outline
from labrig.vision.fit.curve_fit import spread
from labrig.vision.fit.outline_blocks import Blocks
from labrig.vision.image.image import GreyImage
from labrig.vision.thresholds import (
    END_EARLY_RATIO,
    HIDDEN_SIGMA_MAX_PX,
    LENGTH_ERROR_MAX_PX,
    LENGTH_ERROR_MAX_RATIO,
    OUTLINE_BOTH_SHARE_MIN,
    OUTLINE_RESIDUAL_MAX_RATIO,
    OUTLINE_SEEN_SHARE_MIN,
    OUTLINE_SIGMA_MAX_PX,
    OUTLINE_SIGMA_MAX_RATIO,
    OUTLINE_START_SHARE_MIN,
    OUTLINE_TAPER_SUM_MAX_RATIOS,
    OUTLINE_THICKNESS_MIN_PX,
    OUTLINE_WIDTH_SCATTER_MAX_RATIO,
    START_TURN_MIN_RAD,
    START_TURN_SIGMAS,
    STATED_LENGTH_MAX_RATIO,
    STATED_PLACE_MAX_PX,
)
from labrig.vision.uncertainty.parts import calibration_m

FloatArray = npt.NDArray[np.float64]

START_SHARE = 1 / 12  # of a curve, that shows its direction at the clamp
ASSUMED = "measured in the image, not stated: "  # so the warning begins that lists it
HIDDEN = (
    "check of hidden parts failed: where the strip is hidden or unclear it is known to "
    "±{loose:.1f} pixels only; make more of it visible, or state places there (--through)."
)
ENDS_ELSEWHERE = (
    "check of the end failed: {where}; check the length and px_per_mm, or measure it (--to-end)."
)
BY_PATH = (
    "the strip's edges are too faint to be measured: the curve follows what looks most like a "
    "strip from one stated place to the next"
)
START_UNSEEN = (
    "check of the start failed: the first eighth of the best path shows no two edges; "
    "check clamp_px."
)
STATED_RIVAL_RATIO = 2.0  # of the largest sigma, with rival edges, of a strip that is stated
TURNED_MIN_RAD = 0.14  # 8 degrees, from the stated direction to the first part of the curve
TURNED_START_SHARE = 0.03  # of the length: that first part
TURNED = (
    "the strip leaves the clamp {degrees:.0f} degrees beside the stated direction, by which x and "
    "y are turned; state a place nearer to the clamp (--along-px)"
)
RIVAL_STEP = "check of the edges failed"  # the step that a refusal for rival edges names


def outline_fault(outline: Outline, optics: Optics, strip: StripGeometry) -> CurveFinding | None:
    """Return why an outline is no strip's; None where it passes."""
    why = _shape_fault(outline, optics, strip)
    return CurveFinding(refusal=why) if why else _unsure_fault(outline, optics)


def path_fault(outline: Outline) -> CurveFinding | None:
    """Return why a path through stated places is no curve; None where it is."""
    sigma_px = outline.fit.inner_sigma_px
    return _hidden(outline, sigma_px) if sigma_px.max() > STATED_PLACE_MAX_PX else None


def _shape_fault(outline: Outline, optics: Optics, strip: StripGeometry) -> str:
    """Return why nothing of this course and width is the strip, as a sentence; empty: it may be."""
    fit, located = outline.fit, outline.located
    blocks, total = fit.blocks, fit.shape.basis.total_px
    width = located.thickness_px
    unseen = "" if optics.stated_places_px else _unseen_fault(blocks)
    if unseen:
        return unseen
    wide = _width_fault(outline)
    if wide:
        return wide
    if fit.residual_px > max(1.0, OUTLINE_RESIDUAL_MAX_RATIO * width):
        return (
            f"check of the fit failed: the best curve misses the strip by {fit.residual_px:.1f} "
            "pixels; something else was followed: state direction (--along-px) or thickness."
        )
    turned = _start_turn_rad(outline, optics)
    if abs(turned) > START_TURN_SIGMAS * max(START_TURN_MIN_RAD, optics.clamp_angle_sigma_rad):
        return (
            "check of the start failed: what was followed leaves the clamp "
            f"{math.degrees(turned):+.0f} degrees from the stated direction; check clamp_px and "
            "the direction (--along-px), or mask what lies beside the strip (--mask)."
        )
    if total < END_EARLY_RATIO * located.length_px:
        return (
            f"check of the end failed: the strip's profile is seen on the first {total:.0f} pixels "
            f"of a path of {located.length_px:.0f}; state the length, or mask what crosses the "
            "strip (--mask)."
        )
    return _end_fault(outline, optics, strip, total) or _place_fault(outline, optics)


def _unsure_fault(outline: Outline, optics: Optics) -> CurveFinding | None:
    """Return why a curve is known too little somewhere; None where it is known well enough."""
    fit = outline.fit
    most = min(OUTLINE_SIGMA_MAX_PX, OUTLINE_SIGMA_MAX_RATIO * outline.located.thickness_px)
    most = max(HIDDEN_SIGMA_MAX_PX, most)
    sigma_px = fit.inner_sigma_px
    stated = bool(optics.stated_places_px)
    if stated and fit.rival_px is not None and sigma_px.max() < STATED_RIVAL_RATIO * most:
        # which edge is the strip's only widens what is known of one that is stated
        sigma_px = replace(fit, rival_px=None).inner_sigma_px
    if not sigma_px.max() > most:
        return None
    if fit.rival_px is None or not has_rival(outline):
        return _hidden(outline, sigma_px)
    beside = fit.rival_px.max(axis=0)
    why = (
        f"{RIVAL_STEP}: beside an edge of the strip there is another one that is "
        f"as clear, {beside.max():.0f} pixels further out; light the strip evenly, "
        "state the thickness, or mask what lies beside it (--mask)."
    )
    return CurveFinding(refusal=why, refused_at_px=_pixel(outline, beside))


def _hidden(outline: Outline, sigma_px: FloatArray) -> CurveFinding:
    why = HIDDEN.format(loose=sigma_px.max())
    return CurveFinding(refusal=why, refused_at_px=_pixel(outline, sigma_px))


def _pixel(outline: Outline, values: FloatArray) -> Pixel:
    """Return where in the image the largest of some values (nodes,) is."""
    u, v = outline.nodes_px[int(values.argmax())]
    return float(u), float(v)


def _unseen_fault(blocks: Blocks) -> str:
    """Return why too little of a path is seen; with stated places its uncertainty says that."""
    eighth = max(2, len(blocks.seen) // 8)
    share, both = float(blocks.seen.mean()), float(blocks.by_edges.mean())
    if share < OUTLINE_SEEN_SHARE_MIN or both < OUTLINE_BOTH_SHARE_MIN * share:
        return (
            f"search failed: only {both:.0%} of the best path shows two edges; check clamp_px and "
            "the direction (--along-px), state the length or mask what confuses."
        )
    if blocks.seen[:eighth].mean() < OUTLINE_START_SHARE_MIN:
        return START_UNSEEN
    return ""


def _width_fault(outline: Outline) -> str:
    """Return why a strip does not change its width like this; empty where it may."""
    fit, width = outline.fit, outline.located.thickness_px
    if fit.width_scatter_px > OUTLINE_WIDTH_SCATTER_MAX_RATIO * width:
        return (
            f"check of the width failed: what was followed is {width:.1f} pixels thick and changes "
            f"by {fit.width_scatter_px:.1f} from place to place; state the thickness, or choose "
            "another colour channel (--channel)."
        )
    thicker_and_thinner = float(np.abs(np.diff(fit.taper)).sum())
    once_or_twice, frayed = OUTLINE_TAPER_SUM_MAX_RATIOS
    if thicker_and_thinner > max(once_or_twice, frayed * fit.shape.basis.total_px / fit.width_px):
        return (
            f"check of the width failed: what was followed is {width:.1f} pixels thick and becomes "
            "thinner and thicker again along its length; state the thickness, mask what lies "
            "beside it (--mask), or choose another colour channel (--channel)."
        )
    return ""


def _start_turn_rad(outline: Outline, optics: Optics) -> float:
    """Return the angle from the stated direction to the curve's, over its first part."""
    if not optics.clamp_angle_known:
        return 0.0
    shape = outline.fit.shape
    few = max(1, round(START_SHARE * len(shape.x)))
    heading = math.atan2(shape.y[few] - shape.y[0], shape.x[few] - shape.x[0])
    return math.remainder(heading - optics.clamp_angle_rad, 2 * math.pi)


def has_rival(outline: Outline) -> bool:
    """Return whether it is not known which of two edges is the strip's."""
    rival = outline.fit.rival_px
    return rival is not None and bool(
        rival.max() > max(HIDDEN_SIGMA_MAX_PX, 0.2 * outline.fit.width_px)
    )


def _end_fault(outline: Outline, optics: Optics, strip: StripGeometry, total: float) -> str:
    if not strip.length_known:
        return ""
    beyond = _beyond_px(outline, total)
    # one that tapers may seem to end early; what a thin one seems to go on as is often a wire
    early = late = 0.0 if strip.thickness_known else STATED_LENGTH_MAX_RATIO * total
    if not strip.thickness_known and outline.fit.width_px > OUTLINE_THICKNESS_MIN_PX:
        late = math.inf
    if -early <= beyond <= late:
        return ""
    return ENDS_ELSEWHERE.format(where=_ends_elsewhere(outline, optics, beyond, total))


def _end_doubt(outline: Outline, optics: Optics, beyond_px: float, total_px: float) -> str:
    """Return why a curve that was cut at its stated length is doubted; empty where it is not.

    It may have gone on into another thing long before.
    """
    if beyond_px <= 0.0:
        return ""
    return ENDS_ELSEWHERE.format(where=_ends_elsewhere(outline, optics, beyond_px, total_px))


def _beyond_px(outline: Outline, total: float) -> float:
    """Return how far the strip is seen beyond its stated length; 0 where that is no further."""
    beyond = outline.end_px - total
    allowed = max(
        LENGTH_ERROR_MAX_PX, LENGTH_ERROR_MAX_RATIO * total, 0.5 * outline.located.thickness_px
    )
    return beyond if abs(beyond) > allowed else 0.0


def _ends_elsewhere(outline: Outline, optics: Optics, beyond_px: float, total_px: float) -> str:
    stated = f"the stated {total_px / optics.px_per_mm:.1f} mm"
    beyond_mm = abs(beyond_px) / optics.px_per_mm
    if beyond_px > 0 and not outline.ends_in_sight:
        return f"the strip goes on for at least {beyond_mm:.1f} mm beyond {stated}"
    return f"the strip ends {beyond_mm:.1f} mm {'after' if beyond_px > 0 else 'before'} {stated}"


def _place_fault(outline: Outline, optics: Optics) -> str:
    """Return which of the stated places the curve does not pass; empty where it passes all."""
    nodes = outline.nodes_px
    allowed = max(STATED_PLACE_MAX_PX, 0.5 * outline.located.thickness_px)
    for u, v in optics.stated_places_px:
        apart = float(np.hypot(nodes[:, 0] - u, nodes[:, 1] - v).min())
        if apart > allowed:
            return (
                f"check of the stated places failed: the strip's edges lie {apart:.0f} pixels "
                f"beside {u:.0f},{v:.0f}; state that place again, or more places beside it."
            )
    return ""


def outline_in_metres(
    outline: Outline, images: Sequence[GreyImage], optics: Optics, strip: StripGeometry
) -> NeutralCurve:
    """Return the curve in metres, or why a check refuses it."""
    fit, shape, ppm = outline.fit, outline.fit.shape, optics.px_per_m
    covariance = fit.covariance
    unit = np.concatenate([[1 / ppm, 1.0], np.full(shape.basis.size - 2, ppm)])
    seen = _seen_nodes(outline)
    contrast = float(np.median(fit.blocks.strength[fit.blocks.seen]))
    sigma_m = np.hypot(
        fit.sigma_px / ppm, calibration_m(shape.x / ppm, shape.y / ppm, shape.phi, optics)
    )
    said = judge_outline(
        SeenOutline(
            fit=fit,
            context=OutlineContext(
                image=images[0],
                channels=images,
                optics=outline.optics,
                sign=outline.located.sign,
            ),
            sigma_px=sigma_m * ppm,
            edges_seen=not outline.by_path,
            end_measured=not (strip.length_known or optics.tip_px or outline.leaves_image),
        )
    )
    outline = replace(outline, end_sigma_px=math.hypot(outline.end_sigma_px, said.end_widening_px))
    warned = (*_assumed(outline, optics, strip), *_turned(outline, optics))
    warned += (BY_PATH,) if outline.by_path else ()
    beyond = _beyond_px(outline, shape.basis.total_px) if strip.length_known else 0.0
    if beyond:
        where = _ends_elsewhere(outline, optics, beyond, shape.basis.total_px)
        warned += (f"as its profile shows, {where}, up to which the curve was taken",)
    if said.why:
        return NeutralCurve(ok=False, why=said.why, refused_at_px=said.refused_at_px)
    return NeutralCurve(
        ok=True,
        doubt=_end_doubt(outline, optics, beyond, shape.basis.total_px),
        warnings=(*images[0].warnings, *warned, *said.warnings),
        s_m=shape.basis.s / ppm,
        x_m=shape.x / ppm,
        y_m=shape.y / ppm,
        curvature_per_m=shape.k * ppm,
        sigma_m=np.hypot(sigma_m, said.widening_px / ppm),
        curvature_sigma_per_m=spread(shape.basis.curvature, covariance[2:, 2:]) * ppm,
        curvature_resolution_m=shape.basis.free_px / ppm / max(1, shape.basis.size - 2),
        points_px=outline.nodes_px,
        parameters=shape.parameters * unit,
        covariance=covariance * np.outer(unit, unit),
        normal_modes=shape.normal_modes() / ppm / unit,
        free_length_m=shape.basis.free_px / ppm,
        thickness_m=float(np.median(fit.blocks.width_px[fit.blocks.by_edges])) / ppm,
        polarity="bright" if outline.located.sign > 0 else "dark",
        covered=0.0 if outline.by_path else float(fit.blocks.seen.mean()),
        seen=seen,
        residual_px=fit.residual_px,
        end_sigma_m=0.0 if strip.length_known else outline.end_sigma_px / ppm,
        contrast=outline.located.edge,
        snr=contrast,
        excess_px=np.zeros(len(seen)),
        lateral_bias_px=np.zeros(len(seen)),
        side_face_px=np.zeros(len(seen)),
    )


def _seen_nodes(outline: Outline) -> npt.NDArray[np.bool_]:
    """Return (nodes,) where the strip's edges were seen; nowhere along a path without them."""
    blocks = outline.fit.blocks
    seen = np.zeros(len(outline.fit.shape.x), dtype=bool)
    if outline.by_path:
        return seen
    many = max(1, int(np.median(np.diff(blocks.node))))
    for node in blocks.node[blocks.seen]:
        seen[max(0, node - many // 2 - 1) : node + many // 2 + 2] = True
    return seen


def _turned(outline: Outline, optics: Optics) -> list[str]:
    """Return that the strip leaves the clamp beside the stated direction, if it plainly does.

    Whoever states it by a place far along a bent strip states a chord; x and y are turned by that.
    """
    phi = outline.fit.shape.phi
    first = float(phi[: max(1, round(TURNED_START_SHARE * len(phi)))].mean())
    beside = abs(math.remainder(first - optics.clamp_angle_rad, 2 * math.pi))
    if not optics.clamp_angle_known or beside < TURNED_MIN_RAD:
        return []
    return [TURNED.format(degrees=math.degrees(beside))]


def _assumed(outline: Outline, optics: Optics, strip: StripGeometry) -> list[str]:
    """Return what was measured because it was not stated, for whoever reads the curve."""
    found = []
    total_mm = outline.fit.shape.basis.total_px / optics.px_per_mm
    if not strip.thickness_known:
        thick = float(np.median(outline.fit.blocks.width_px[outline.fit.blocks.by_edges]))
        found.append(f"thickness {thick / optics.px_per_mm:.2f} mm ({thick:.1f} pixels)")
    if not strip.length_known:
        where = f"to its end, ±{outline.end_sigma_px / optics.px_per_mm:.1f} mm"
        if optics.tip_px is not None:
            where = f"to the stated tip, ±{outline.end_sigma_px / optics.px_per_mm:.1f} mm"
        elif outline.goes_on:
            where += "; something that looks different may go on there"
        if outline.leaves_image:
            where = "to the border of the image; its end is not seen"
        found.append(f"length {total_mm:.1f} mm ({where})")
    if not optics.clamp_angle_known:
        degrees = math.degrees(outline.fit.shape.phi[0])
        found.append(f"direction at the clamp {degrees:+.1f} degrees from the image's rows")
    return [f"{ASSUMED}{', '.join(found)}"] if found else []
