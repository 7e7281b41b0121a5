"""`neutral_curve`: one image in, the sheet's curve with its uncertainty out, or a reason."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.checks.verdict import Verdict
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extraction.curve_search import CurveSearch
from labrig.vision.extraction.metric_curve import refused, reported
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
from labrig.vision.uncertainty.apparent_width import (
    corrupted_cells,
    excess_width_px,
    something_lies_along,
)
from labrig.vision.uncertainty.lateral_bias import lateral_bias_px

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
        return reported(_followed(best, start), best.verdict)
    best = search.search()
    if best is None:
        return NeutralCurve(
            ok=False,
            why="search failed: no path that a sheet could take leaves the clamp; check clamp_px.",
        )
    if best.verdict.why:
        verdict = _blamed(best.verdict) if search.led_by_lines else best.verdict
        return refused(_seen(best), best.verdict, verdict)
    second_sheet = second_sheet_contrast(search, best)
    excess = excess_width_px(best.fit, best.context)
    if something_lies_along(excess, best.fit):
        return _bridged(search, best, excess, second_sheet)
    seen = replace(
        _seen(best),
        excess_px=np.maximum(excess, best.wider_px),
        # light on one side moves no edge
        lateral_bias_px=None if best.between_edges else lateral_bias_px(best.fit, best.context),
        second_sheet=second_sheet,
        wires=search.wires,
    )
    return reported(seen, best.verdict)


def _seen(best: CurveCandidate) -> SeenCurve:
    return SeenCurve(fit=best.fit, context=best.context, sheet_end=best.sheet_end)


def _followed(best: CurveCandidate, start: NeutralCurve) -> SeenCurve:
    """Return a followed curve, with what was measured beside the one before."""
    return replace(
        _seen(best),
        followed=True,
        excess_px=start.excess_px,
        lateral_bias_px=start.lateral_bias_px,
        wires=start.wires,
    )


def _bridged(
    search: CurveSearch, found: CurveCandidate, excess: FloatArray, second_sheet: float
) -> NeutralCurve:
    """Return the curve without the cells where something lies along the sheet."""
    before = found.fit.section.corrupted
    corrupted = corrupted_cells(excess)
    section = replace(
        found.fit.section, corrupted=corrupted if before is None else corrupted | before
    )
    fit = fit_intensities(found.fit.shape, found.context, section)
    again = search.judged(fit, found.context)
    if not again.verdict.why:  # else the check says what lies along the curve as it was
        found, excess = again, excess_width_px(fit, found.context)
    seen = replace(_seen(found), excess_px=excess, second_sheet=second_sheet, left_out_along=True)
    return reported(seen, found.verdict)


def _blamed(verdict: Verdict) -> Verdict:
    """Return the refusal with the wire named first, as its probable cause."""
    message = (
        "search failed: a wire, or something else that is straight, lies along the best path; take "
        f"it away, or mask it (--mask). Without it: {verdict.why}"
    )
    return replace(verdict, why=message)
