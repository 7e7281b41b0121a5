"""`neutral_curve`: one image in, the sheet's curve with its uncertainty out, or a reason."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.checks.apparent_width import (
    corrupted_cells,
    excess_width_px,
    something_lies_along,
)
from labrig.vision.checks.lateral_bias import lateral_bias_px
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extraction.curve_search import CurveSearch
from labrig.vision.extraction.refinement import CurveCandidate
from labrig.vision.extraction.second_sheet import second_sheet_contrast
from labrig.vision.fit.curve_fit import fit_intensities
from labrig.vision.fit.thickness import visible_thickness_m
from labrig.vision.image.downscaling import (
    downscaled_image,
    downscaled_optics,
    downscaling_factor,
    in_camera_pixels,
    scaled_curve,
)
from labrig.vision.image.image import GreyImage, ImageError, read_grey_image
from labrig.vision.thresholds import (
    BRIDGED_SIGMA_MAX_PX,
    EXCESS_WIDTH_MAX_PX,
    EXCESS_WIDTH_MAX_RATIO,
    REFLECTION_CONTRAST_MAX_RATIO,
)
from labrig.vision.uncertainty.metric_curve import blamed, report, with_wires

FloatArray = npt.NDArray[np.float64]


def neutral_curve(
    image: npt.NDArray[Any],
    optics: Optics,
    strip: StripGeometry,
    *,
    start: NeutralCurve | None = None,
) -> NeutralCurve:
    """Return the neutral curve of the sheet in `image` (rows, columns), 8 or 16 bit grey.

    `start`: the curve of an image shortly before; it is followed, which is several times faster,
    and given up for a search from the clamp where its curve fails the self-check. What cannot be
    measured comes back with `ok` False and the reason, never raised.
    """
    try:
        grey_image = read_grey_image(image, optics)
    except ImageError as error:
        return NeutralCurve(ok=False, why=f"check of the image failed: {error}")
    if not strip.thickness_known:
        seen_m = start.thickness_m if start is not None and start.ok else None
        strip = replace(strip, thickness_m=seen_m or visible_thickness_m(grey_image, optics, strip))
    by = downscaling_factor(strip.thickness_m * optics.px_per_m)
    if by == 1:
        return _found(grey_image, optics, strip, start)
    grey_image, optics = downscaled_image(grey_image, by), downscaled_optics(optics, by)
    start = scaled_curve(start, 1 / by) if start is not None else None
    return in_camera_pixels(_found(grey_image, optics, strip, start), by)


def _found(
    image: GreyImage, optics: Optics, strip: StripGeometry, start: NeutralCurve | None
) -> NeutralCurve:
    """Return the curve, or why there is none."""
    search = CurveSearch(image, optics, strip)
    best = search.follow(start) if start is not None and start.ok else None
    if best is not None and start is not None:
        curve = report(best.fit, best.context, best.verdict, start.excess_px, start.lateral_bias_px)
        return replace(curve, wires=start.wires)
    best = search.search()
    if best is None:
        return NeutralCurve(
            ok=False,
            why="search failed: no path that a sheet could take leaves the clamp; check clamp_px.",
        )
    beside = 0.0 if best.verdict.why else second_sheet_contrast(search, best)
    if beside > REFLECTION_CONTRAST_MAX_RATIO:
        return NeutralCurve(
            ok=False,
            why="check of the surroundings failed: "
            "two sheets leave the clamp side by side, and nothing shows which is meant; take "
            "one away, or mask it in the image.",
        )
    if best.verdict.why:
        verdict = blamed(best.verdict) if search.led_by_lines else best.verdict
        return report(best.fit, best.context, verdict)
    excess = excess_width_px(best.fit, best.context)
    if something_lies_along(excess, best.fit):
        return _bridged(search, best, excess)
    excess = np.maximum(excess, best.wider_px)
    if excess.max() > max(EXCESS_WIDTH_MAX_PX, EXCESS_WIDTH_MAX_RATIO * search.basis.total_px):
        return NeutralCurve(
            ok=False,
            why="check of the width failed: "
            f"what was followed looks up to {excess.max():.1f} pixels wider than the sheet is "
            "thick, and nothing shows which part of it is the sheet's edge; light the edge, or "
            "check the sheet's thickness.",
        )
    # light on one side moves no edge
    bias_px = None if best.between_edges else lateral_bias_px(best.fit, best.context)
    curve = report(best.fit, best.context, best.verdict, excess, bias_px)
    if beside > 0:
        message = (
            f"something like the sheet, {beside:.0%} as strong, lies beside it, such as its "
            "reflection; the stronger of the two was followed"
        )
        curve = replace(curve, warnings=(*curve.warnings, message))
    return with_wires(curve, search.wires, image.grey.shape)


def _bridged(search: CurveSearch, found: CurveCandidate, excess: FloatArray) -> NeutralCurve:
    """Return the curve without the cells where something lies along the sheet.

    A refusal where the rest does not show to about a pixel where the sheet is.
    """
    before = found.fit.section.corrupted
    corrupted = corrupted_cells(excess)
    section = replace(
        found.fit.section, corrupted=corrupted if before is None else corrupted | before
    )
    fit = fit_intensities(found.fit.shape, found.context, section)
    again = search.judged(fit, found.context)
    if not again.verdict.why:
        excess = excess_width_px(fit, found.context)
        curve = report(fit, found.context, again.verdict, excess)
        loose = curve.sigma_m.max() * search.optics.px_per_m > BRIDGED_SIGMA_MAX_PX
        if not loose and not something_lies_along(excess, fit):
            message = "something lies along the sheet, such as a wire; it was left out there"
            return replace(curve, warnings=(*curve.warnings, message))
    return NeutralCurve(
        ok=False,
        why="check of the width failed: "
        "something lies along the sheet and cannot be separated from it, such as a wire; "
        "take it away, or mask it in the image.",
    )
