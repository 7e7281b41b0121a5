"""`neutral_curve`: one image in, the sheet's curve with its uncertainty out, or a reason."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.errors import BadInputError, type_in_words
from labrig.vision.calibration.optics import ColourChannel, Optics
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.checks.verdict import Verdict
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extraction.curve_search import CurveSearch
from labrig.vision.extraction.metric_curve import refused, reported
from labrig.vision.extraction.refinement import CurveCandidate
from labrig.vision.extraction.salience.second_look import changed_by_it, seen_again
from labrig.vision.extraction.second_sheet import second_sheet_contrast
from labrig.vision.extraction.second_size import outline_curve
from labrig.vision.fit.context import roll_mask
from labrig.vision.fit.curve_fit import fit_intensities
from labrig.vision.fit.thickness import visible_thickness_m
from labrig.vision.image.colour_notes import DIFFERENCES_USED, GREY_USED
from labrig.vision.image.downscaling import (
    downscaled_image,
    downscaled_optics,
    downscaling_factor,
    in_camera_pixels,
    scaled_curve,
)
from labrig.vision.image.image import GreyImage, ImageError, is_coloured, read_grey_image
from labrig.vision.search.straightened import distances
from labrig.vision.thresholds import (
    ELSEWHERE_MIN_PX,
    OUTLINE_THICKNESS_MIN_PX,
    SATURATED_SHARE_MAX,
)
from labrig.vision.uncertainty.apparent_width import (
    corrupted_cells,
    excess_width_px,
    something_lies_along,
)
from labrig.vision.uncertainty.lateral_bias import lateral_bias_px
from model.measurements.known_arguments import known_arguments

FloatArray = npt.NDArray[np.float64]

FOUND_ANGLE_SIGMA_RAD = 0.05  # of the direction at the clamp, as the edges show it
DIFFERENCES = (ColourChannel.RED_GREEN, ColourChannel.GREEN_BLUE)


@known_arguments
def neutral_curve(
    image: npt.NDArray[Any],
    optics: Optics,
    strip: StripGeometry,
    *,
    start: NeutralCurve | None = None,
) -> NeutralCurve:
    """Return the neutral curve of the sheet in an image, from the clamp to the visible end.

    image: (rows, columns) grey; (rows, columns, 3) blue, green, red, or with alpha as a fourth, in
    OpenCV's order; Pillow and imageio read the colours the other way round. uint8, uint16, or
    floats in levels of the camera. `labrig.read_image` and `labrig.load_optics` read the files.

    start: the curve of an image shortly before; it is followed, which is several times faster, and
    given up for a search from the clamp where its curve fails the self-check.

    The curve has places in m and curvatures in 1/m, all with standard uncertainties. Where neither
    length, tip nor places are stated, a second look at what stands out in the picture may lead it
    on or cut it; a curve that is followed is looked at again only where the one before had been
    changed by that. What cannot be measured comes back with `ok` False and the reason, `why`.

    Raises BadInputError for arguments of another type alone.
    """
    _refuse_other_types(optics, strip, start)
    found = unconfirmed_curve(image, optics, strip, start=start)
    if found.ok and start is not None and start.ok and not changed_by_it(start):
        return found.confirmed()
    return seen_again(found, image, optics, strip).confirmed()


def _refuse_other_types(optics: object, strip: object, start: object) -> None:
    """Raise BadInputError for what stands in the place of one of these: a caller may err."""
    if not isinstance(optics, Optics):
        raise BadInputError(
            f"optics: a labrig.Optics is needed, not {type_in_words(optics)}; "
            "labrig.load_optics reads a file."
        )
    if not isinstance(strip, StripGeometry):
        raise BadInputError(f"strip: a labrig.StripGeometry is needed, not {type_in_words(strip)}.")
    if start is not None and not isinstance(start, NeutralCurve):
        raise BadInputError(f"start: a labrig.NeutralCurve is needed, not {type_in_words(start)}.")


def unconfirmed_curve(
    image: npt.NDArray[Any],
    optics: Optics,
    strip: StripGeometry,
    *,
    start: NeutralCurve | None = None,
) -> NeutralCurve:
    """Return the curve of the sheet in `image` (rows, columns), 8 or 16 bit grey.

    What another look at the picture may settle is a doubt of the curve, and no refusal yet. What
    cannot be measured comes back with `ok` False and the reason, never raised.
    """
    return _with_place(_unconfirmed(image, optics, strip, start))


def _with_place(curve: NeutralCurve) -> NeutralCurve:
    """Return it with the place of a refusal in its sentence, if it has one."""
    if curve.refused_at_px is None:
        return curve
    u, v = curve.refused_at_px
    return replace(curve, why=f"{curve.why} Look near {u:.0f},{v:.0f}.")


def _unconfirmed(
    image: npt.NDArray[Any], optics: Optics, strip: StripGeometry, start: NeutralCurve | None
) -> NeutralCurve:
    try:
        grey_image = read_grey_image(image, optics)
    except ImageError as error:
        return NeutralCurve(ok=False, why=f"check of the image failed: {error}")
    unusable = _place_outside(optics, grey_image) or _all_hidden(optics, grey_image)
    if unusable:
        return NeutralCurve(ok=False, why=unusable)
    if optics.tip_px is not None:  # the length is measured, whatever is stated
        strip = replace(strip, length_known=False, elongation_m=0.0)
    if not strip.length_known or not optics.clamp_angle_known or optics.through_px:
        found = _by_edges(image, grey_image, optics, strip, start)
        if found.ok and strip.length_known:
            return _finer(replace(found, doubt=""), grey_image, optics, strip)
        return found if found.ok else _saturated(found, grey_image)
    if not strip.thickness_known:
        return _of_unstated_thickness(image, grey_image, optics, strip, start)
    if _is_thick(strip, optics):
        found = _by_edges(image, grey_image, optics, strip, start)
        if found.ok:
            return found
    found = _by_intensities(grey_image, optics, strip, start)
    return found if found.ok else _saturated(found, grey_image)


def _is_thick(strip: StripGeometry, optics: Optics) -> bool:
    """Return whether the edges of a strip show more than its intensities do."""
    thickness_px = strip.thickness_m * optics.px_per_m
    return thickness_px > OUTLINE_THICKNESS_MIN_PX and strip.elongation_m == 0


def _of_unstated_thickness(
    image: npt.NDArray[Any],
    grey_image: GreyImage,
    optics: Optics,
    strip: StripGeometry,
    start: NeutralCurve | None,
) -> NeutralCurve:
    """Return the curve of a strip of which the length is stated: by its edges, then finer.

    What the path from the clamp seems thick is often another thing. A thin strip that is followed
    is measured by its intensities, as before.
    """
    followed = start is not None and start.ok
    by_edges = None
    if start is not None and start.ok:
        strip = replace(strip, thickness_m=start.thickness_m)
    if _is_thick(strip, optics) if followed else strip.elongation_m == 0:
        by_edges = _by_edges(image, grey_image, optics, strip, start)
        if by_edges.ok and followed:
            return replace(by_edges, doubt="")
        if by_edges.ok and not by_edges.doubt:
            return _finer(by_edges, grey_image, optics, strip)
    unstated = strip
    if not followed:
        thickness_m = visible_thickness_m(grey_image, optics, strip)
        strip = replace(strip, thickness_m=thickness_m)
    found = _by_intensities(grey_image, optics, strip, start)
    if by_edges is not None and by_edges.ok:
        # seen beyond its stated length: another thing may end there
        if found.ok and _leads_elsewhere(found, by_edges, optics):
            return found
        return _finer(replace(by_edges, doubt=""), grey_image, optics, unstated)
    if found.ok:
        return found
    by_edges = by_edges or _by_edges(image, grey_image, optics, strip, start)
    if by_edges.ok:
        return replace(by_edges, doubt="")
    # of what was followed it says more why it is no strip than that nothing was found
    told = found if by_edges.why.startswith("search failed") else by_edges
    return _saturated(told, grey_image)


def _leads_elsewhere(one: NeutralCurve, other: NeutralCurve, optics: Optics) -> bool:
    """Return whether a curve leaves another one by more than that one's thickness."""
    return _aside_px(one, other) > max(ELSEWHERE_MIN_PX, other.thickness_m * optics.px_per_m)


def _aside_px(one: NeutralCurve, other: NeutralCurve) -> float:
    """Return how far a curve lies beside another one, at most."""
    return float(distances(one.points_px, other.points_px).min(axis=1).max())


def _place_outside(optics: Optics, image: GreyImage) -> str:
    """Return which of the stated places is not in the image, as a sentence; empty: all are."""
    rows, columns = image.grey.shape
    for u, v in optics.stated_places_px:
        if not (0 <= u < columns and 0 <= v < rows):
            return (
                f"check of the stated places failed: {u:g},{v:g} lies outside of the image of "
                f"{columns} x {rows} pixels; check --tip-px and --through, or tip_px "
                "and through_px of optics.json."
            )
    return ""


def _all_hidden(optics: Optics, image: GreyImage) -> str:
    """Return that nothing of the image is to be used, as a sentence; empty: something is."""
    if not roll_mask(optics, image.grey.shape).all():
        return ""
    return "check of the image failed: masks or rolls hide all of it; check mask_px and rolls_px."


def _by_edges(
    image: npt.NDArray[Any],
    grey_image: GreyImage,
    optics: Optics,
    strip: StripGeometry,
    start: NeutralCurve | None,
) -> NeutralCurve:
    """Return the curve between the strip's edges, in whichever colours they show."""
    images = [grey_image]
    if optics.channel == ColourChannel.AUTO and is_coloured(image):
        for channel in DIFFERENCES:
            try:
                chosen = optics.model_copy(update={"channel": channel})
                images.append(read_grey_image(image, chosen))
            except ImageError:  # such as a uniform one: no edge shows in it
                continue
        images[0] = replace(grey_image, warnings=(DIFFERENCES_USED,))
    return outline_curve(
        images, optics, strip, start=start if start is not None and start.ok else None
    )


def _finer(
    found: NeutralCurve, grey_image: GreyImage, optics: Optics, strip: StripGeometry
) -> NeutralCurve:
    """Return the curve of a thin strip's intensities, with the direction that its edges show.

    It is known better than that between the edges; where both differ, that is kept.
    """
    ppm = optics.px_per_m
    if found.thickness_m * ppm > OUTLINE_THICKNESS_MIN_PX:
        return found
    few = max(1, len(found.x_m) // 20)
    heading = math.atan2(found.y_m[few] - found.y_m[0], found.x_m[few] - found.x_m[0])
    known = {
        "clamp_angle_known": True,
        "clamp_angle_rad": heading,
        "clamp_angle_sigma_rad": FOUND_ANGLE_SIGMA_RAD,
    }
    thickness_m = strip.thickness_m
    if not strip.thickness_known:
        # edges that are few pixels apart look further apart than they are
        stated = optics.clamp_angle_known
        thickness_m = (
            visible_thickness_m(grey_image, optics, strip) if stated else found.thickness_m
        )
    there = optics.model_copy(update=known)
    finer = _by_intensities(grey_image, there, replace(strip, thickness_m=thickness_m), None)
    if not finer.ok:
        return found
    if _aside_px(finer, found) > max(1.0, 0.25 * found.thickness_m * ppm):
        return found
    said = tuple(text for text in found.warnings if text not in finer.warnings)
    # the grey values that it used are named by that, too
    own = tuple(t for t in finer.warnings if t != GREY_USED or DIFFERENCES_USED not in said)
    return replace(finer, warnings=own + said)


def _by_intensities(
    grey_image: GreyImage, optics: Optics, strip: StripGeometry, start: NeutralCurve | None
) -> NeutralCurve:
    by = downscaling_factor(strip.thickness_m * optics.px_per_m)
    if by == 1:
        return _straight_or_bending(grey_image, optics, strip, start)
    grey_image, optics = downscaled_image(grey_image, by), downscaled_optics(optics, by)
    start = scaled_curve(start, 1 / by) if start is not None else None
    return in_camera_pixels(_straight_or_bending(grey_image, optics, strip, start), by)


def _straight_or_bending(
    image: GreyImage, optics: Optics, strip: StripGeometry, start: NeutralCurve | None
) -> NeutralCurve:
    """Return the curve with a straight elongation; where there is none, with one that bends.

    Of two refusals that of the path which shows more of a sheet says more.
    """
    if strip.elongation_m == 0 or not strip.elongation_straight:
        return _found(image, optics, strip, start)
    bending, bent = replace(strip, elongation_straight=False), None
    if start is not None and not start.elongation_straight:
        bent = _found(image, optics, bending, start)
        if bent.ok:
            return bent
    found = _found(image, optics, strip, start)
    if found.ok:
        return found
    bent = bent or _found(image, optics, bending, None)
    return bent if bent.ok or bent.covered > found.covered else found


def _saturated(refusal: NeutralCurve, image: GreyImage) -> NeutralCurve:
    """Return a refusal that names the exposure where hardly a pixel is not at full scale."""
    if image.clipped <= SATURATED_SHARE_MAX:
        return refusal
    why = (
        f"check of the image failed: the image is saturated ({image.clipped:.0%} of the pixels are "
        f"at full scale); shorten the exposure. Without that: {refusal.why}"
    )
    return replace(refusal, why=why)


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
        "search failed: something straight, such as a wire or a shadow, lies along the best path; "
        f"take it away, or mask it (--mask). Without it: {verdict.why}"
    )
    return replace(verdict, why=message)
