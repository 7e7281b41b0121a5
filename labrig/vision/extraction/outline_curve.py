"""Find a strip's curve by its two edges: for strips that are thick, short, shaded or little known.

First it is located: path, thickness and length (`search.locate`). Then a curve is fitted midway
between its edges (`fit.outline`), its end is measured, and both are judged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.checks.contract import CurveFinding
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extraction.likeliest_paths import (
    SAME_MIN_PX,
    SAME_THICKNESS,
    SAME_WIDTHS,
    likeliest_first,
)
from labrig.vision.extraction.outline_report import (
    RIVAL_STEP,
    outline_fault,
    outline_in_metres,
    path_fault,
)
from labrig.vision.extraction.outline_shape import Outline, fitted_outline, outline_along_path
from labrig.vision.fit.context import roll_mask
from labrig.vision.image.image import GreyImage
from labrig.vision.search.located import CLEARNESS_OF_NOTHING, Located
from labrig.vision.search.straightened import distances, resampled
from labrig.vision.search.work import OutlineWork, WorkDoneError
from labrig.vision.thresholds import PATH_THICKNESS_MAX_PX

FloatArray = npt.NDArray[np.float64]
MaskArray = npt.NDArray[np.uint8]

NOTHING_FOUND = (
    "search failed: nothing with two edges leads away from the clamp; check clamp_px, state the "
    "direction (--along-px) or a colour channel (--channel), or light the strip."
)
NOTHING_THROUGH = (
    "search failed: nothing with two edges leads through the stated places; check them "
    "(through_px, tip_px), state a colour channel (--channel), or light the strip."
)
UNSEEN = (
    "search failed: both edges of what was found at the clamp are nowhere seen together; check "
    "clamp_px and the direction (--along-px), or light the strip."
)
UNSEEN_THICKNESS = (
    "search failed: at the clamp no two edges are seen {thickness_mm:.3g} mm ({thickness_px:.1f} "
    "pixels) apart, as thickness_mm and px_per_mm state it; leave the thickness out to have it "
    "measured, or check clamp_px and the direction (--along-px)."
)
UNSEEN_THROUGH = (
    "search failed: both edges of a strip are nowhere seen together between the stated places; "
    "check them (through_px, tip_px), or light the strip."
)
TWO_WAYS = (
    "search failed: two ways that lead away from the clamp look equally like a strip; "
    "state the direction (--along-px) or the thickness, or mask what confuses (--mask)."
)
TOO_MUCH = (
    "search failed: too much in the image looks like the edges of a strip; mask what confuses "
    "(--mask), state length, thickness and direction (--along-px), or crop the image."
)
BEYOND_SHARE = 0.1  # of a path that may lie beyond another's end
LEAVES_WIDTHS, LEAVES_MIN_PX = 1.5, 6.0  # beside another curve: it goes elsewhere
BOTH_SHARE_OF_MORE = 0.7  # of what a longer curve must show of both edges, to be preferred
AS_GOOD_RATIO = 0.6  # of two curves' worth: which one is the strip is not known


@dataclass(frozen=True, eq=False, kw_only=True)
class _Tried:
    """One fitted candidate and why it is no strip; None where it may be one."""

    outline: Outline
    fault: CurveFinding | None

    @property
    def worth(self) -> float:
        """How much of both edges it shows, over the whole of its length."""
        blocks, length = self.outline.fit.blocks, self.outline.fit.shape.basis.total_px
        if not blocks.by_edges.any():
            return 0.0
        clear = float(np.median(blocks.strength[blocks.by_edges]))
        more = max(blocks.by_edges.mean() - BOTH_SHARE_OF_MORE, 0.01)
        return float(length * more * clear)

    @property
    def path_px(self) -> FloatArray:
        """(nodes, 2) its curve in the image."""
        return self.outline.nodes_px


def followed_outline(
    images: Sequence[GreyImage], optics: Optics, strip: StripGeometry, start: NeutralCurve
) -> NeutralCurve:
    """Return the curve between the strip's edges beside that of an image shortly before."""
    images = _without_rolls(images, optics)
    followed = _tried(images, optics, strip, _from_before(start), OutlineWork())
    if followed is None:
        return _refused(_unseen(optics, strip))
    if followed.fault is not None:
        return _refused(followed.fault)
    return outline_in_metres(followed.outline, images, optics, strip)


def searched_outline(
    images: Sequence[GreyImage], optics: Optics, strip: StripGeometry
) -> NeutralCurve:
    """Return the curve between the strip's edges, or why there is none.

    `images`: the same one in each channel in which the strip may show, the likeliest first.
    """
    mask = roll_mask(optics, images[0].grey.shape)
    images = _without_rolls(images, optics)
    work = OutlineWork()
    likeliest = likeliest_first(images, optics, strip, mask, work)
    if not likeliest:
        nothing = NOTHING_THROUGH if optics.stated_places_px else NOTHING_FOUND
        return _refused(CurveFinding(refusal=nothing))
    try:
        tried = _all_tried(images, optics, strip, likeliest, work)
    except WorkDoneError:
        # whether what was not looked at to its end is the strip is not known
        return _refused(CurveFinding(refusal=TOO_MUCH))
    stated = optics.stated_places_px
    best = _chosen_through(tried, likeliest, optics) if stated else _chosen(tried)
    if best is None:
        best = _unseen(optics, strip)
    if isinstance(best, CurveFinding):
        return _refused(best)
    return outline_in_metres(best.outline, images, optics, strip)


def _without_rolls(images: Sequence[GreyImage], optics: Optics) -> Sequence[GreyImage]:
    mask = roll_mask(optics, images[0].grey.shape)
    return [image.without(mask) for image in images] if mask.any() else images


def _all_tried(
    images: Sequence[GreyImage],
    optics: Optics,
    strip: StripGeometry,
    likeliest: Sequence[Located],
    work: OutlineWork,
) -> list[_Tried]:
    """Return what was fitted, each course once."""
    tried: list[_Tried] = []
    for located in likeliest:
        if not any(_same_course(located, each) for each in tried):
            fitted = _tried(images, optics, strip, located, work)
            if fitted is not None:
                tried.append(fitted)
    return tried


def _chosen_through(
    tried: list[_Tried], likeliest: Sequence[Located], optics: Optics
) -> _Tried | CurveFinding:
    """Return the candidate through stated places that shows most of both edges, or why none does.

    That there is a strip through them is stated. So another way through them widens the
    uncertainty; and where edges do not show a thin strip, the path is its curve.
    """
    passing = [each for each in tried if each.fault is None]
    if passing:
        best = max(passing, key=lambda each: each.worth)
        others = [each for each in passing if each.worth > AS_GOOD_RATIO * best.worth]
        apart = max(_apart_px(each, best) for each in others)
        if apart > LEAVES_MIN_PX:
            fit = best.outline.fit.known_to(0.5 * apart)
            best = replace(best, outline=replace(best.outline, fit=fit))
        return best
    thin = likeliest[0].thickness_px <= PATH_THICKNESS_MAX_PX
    whole = bool(optics.through_px) and optics.tip_px is not None
    if whole and thin and likeliest[0].clearness > CLEARNESS_OF_NOTHING:
        outline = outline_along_path(optics, likeliest)
        return path_fault(outline) or _Tried(outline=outline, fault=None)
    return _first_fault(tried) or CurveFinding(refusal=UNSEEN_THROUGH)


def _first_fault(tried: list[_Tried]) -> CurveFinding | None:
    """Return why the likeliest candidate is no strip; None where there is none."""
    return tried[0].fault if tried else None


def _apart_px(one: _Tried, other: _Tried) -> float:
    """Return how far one curve leads from another, at most."""
    path, along = resampled(one.path_px, 2.0), resampled(other.path_px, 2.0)
    return float(distances(path, along).min(axis=1).max())


def _chosen(tried: list[_Tried]) -> _Tried | CurveFinding | None:
    """Return the candidate that shows most of both edges, or why none is the strip.

    None where nothing was fitted.
    """
    passing = [each for each in tried if each.fault is None]
    if not passing:
        return _first_fault(tried)
    best = max(passing, key=lambda each: each.worth)
    for each in tried:
        # where it is not known which edge is the strip's, another channel only hides that
        fault = each.fault
        if fault is not None and fault.refusal.startswith(RIVAL_STEP) and each.worth > best.worth:
            return fault
    for each in passing:
        if each is not best and each.worth > AS_GOOD_RATIO * best.worth and _leaves(each, best):
            return CurveFinding(refusal=TWO_WAYS)
    return best


def _leaves(one: _Tried, other: _Tried) -> bool:
    """Return whether one curve goes elsewhere than another, not just further."""
    aside = max(LEAVES_WIDTHS * other.outline.fit.width_px, LEAVES_MIN_PX)
    path, along = resampled(one.path_px, 2.0), resampled(other.path_px, 2.0)
    near = distances(path, along).argmin(axis=1) < len(along) - 1
    return bool((distances(path, along).min(axis=1)[near] > aside).any())


def _same_course(located: Located, other: _Tried) -> bool:
    """Return whether a path only shows what was fitted already."""
    width = other.outline.fit.width_px
    if not 1 / SAME_THICKNESS < located.thickness_px / width < SAME_THICKNESS:
        return False
    path = resampled(located.path_px, 2.0)
    aside = distances(path, resampled(other.path_px, 2.0)).min(axis=1)
    return bool((aside > max(SAME_WIDTHS * width, SAME_MIN_PX)).mean() < BEYOND_SHARE)


def _from_before(start: NeutralCurve) -> Located:
    px_per_m = _length(start.points_px) / start.s_m[-1]
    return Located(
        path_px=start.points_px,
        thickness_px=float(start.thickness_m * px_per_m),
        edge=start.contrast,
        leaves_image=False,
        sign=1.0 if start.polarity == "bright" else -1.0,
    )


def _length(path: FloatArray) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def _tried(
    images: Sequence[GreyImage],
    optics: Optics,
    strip: StripGeometry,
    located: Located,
    work: OutlineWork,
) -> _Tried | None:
    outline = fitted_outline(images, optics, strip, located, work)
    if outline is None:
        return None
    return _Tried(outline=outline, fault=outline_fault(outline, optics, strip))


def _unseen(optics: Optics, strip: StripGeometry) -> CurveFinding:
    if not strip.thickness_known:
        return CurveFinding(refusal=UNSEEN)
    mm, px = 1e3 * strip.thickness_m, strip.thickness_m * optics.px_per_m
    return CurveFinding(refusal=UNSEEN_THICKNESS.format(thickness_mm=mm, thickness_px=px))


def _refused(fault: CurveFinding) -> NeutralCurve:
    return NeutralCurve(ok=False, why=fault.refusal, refused_at_px=fault.refused_at_px)
