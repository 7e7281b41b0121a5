"""Find a strip's curve by its two edges: for strips that are thick, short, shaded or little known.

First it is located: path, thickness and length (`search.locate`). Then a curve is fitted midway
between its edges (`fit.outline`), its end is measured, and both are judged.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extraction.outline_report import (
    RIVAL_STEP,
    outline_fault,
    outline_in_metres,
)
from labrig.vision.extraction.outline_shape import CLAMP_REACH_PX, fitted_outline
from labrig.vision.fit.context import roll_mask
from labrig.vision.image.image import GreyImage
from labrig.vision.search.locate import Located, locate
from labrig.vision.search.stated_places import locate_through

FloatArray = npt.NDArray[np.float64]
MaskArray = npt.NDArray[np.uint8]

COMPARABLE_RATIO = 0.4  # of a channel's worth to the best one's


def outline_curve(
    images: Sequence[GreyImage],
    optics: Optics,
    strip: StripGeometry,
    *,
    start: NeutralCurve | None = None,
) -> NeutralCurve:
    """Return the curve between the strip's edges, or why there is none.

    `images`: the same one in each channel in which the strip may show, the likeliest first.
    `start`: the curve of an image shortly before.
    """
    mask = roll_mask(optics, images[0].grey.shape)
    if mask.any():
        images = [image.without(mask) for image in images]
    if start is not None:
        followed = _judged(images, optics, strip, _from_before(start))
        if followed.ok:
            return followed
    first = None
    for located in _likeliest_first(images, optics, strip, mask):
        found = _judged(images, optics, strip, located)
        # where it is not known which edge is the strip's, another channel only hides that
        if found.ok or found.why.startswith(RIVAL_STEP):
            return found
        first = first or found
    return first or _judged(images, optics, strip, None)


def _likeliest_first(
    images: Sequence[GreyImage], optics: Optics, strip: StripGeometry, mask: MaskArray
) -> list[Located]:
    """Return what each channel shows, without what is far less clear than another's."""
    found = []
    for image in images:
        located = _located(image, optics, strip, mask)
        if located is not None:
            found.append(located)
    found.sort(key=lambda each: -each.evidence)
    return [each for each in found if each.evidence > COMPARABLE_RATIO * found[0].evidence]


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


def _judged(
    images: Sequence[GreyImage], optics: Optics, strip: StripGeometry, located: Located | None
) -> NeutralCurve:
    if located is None and optics.stated_places_px:
        return _refused(
            "search failed: nothing with two edges leads through the stated places; check them "
            "(through_px, tip_px), state a colour channel (--channel), or light the strip."
        )
    if located is None:
        return _refused(
            "search failed: nothing with two edges leads away from the clamp; check clamp_px, "
            "state the direction (--along-px) or a colour channel (--channel), or light the strip."
        )
    outline = fitted_outline(images, optics, strip, located)
    if outline is None and optics.stated_places_px:
        return _refused(
            "search failed: both edges of a strip are nowhere seen together between the stated "
            "places; check them (through_px, tip_px), or light the strip."
        )
    if outline is None:
        return _refused(
            "search failed: both edges of what was found at the clamp are nowhere seen together; "
            "check clamp_px and the direction (--along-px), or light the strip."
        )
    why = outline_fault(outline, optics, strip)
    return _refused(why) if why else outline_in_metres(outline, images[0], optics, strip)


def _refused(why: str) -> NeutralCurve:
    return NeutralCurve(ok=False, why=why)


def _located(
    image: GreyImage, optics: Optics, strip: StripGeometry, mask: MaskArray
) -> Located | None:
    signs = {"bright": (1.0,), "dark": (-1.0,), "auto": (1.0, -1.0)}[optics.polarity]
    thickness_px = strip.thickness_m * optics.px_per_m if strip.thickness_known else None
    if optics.stated_places_px:
        places = (optics.clamp_px, *optics.stated_places_px)
        return locate_through(image, places, mask=mask, signs=signs, thickness_px=thickness_px)
    stated = optics.clamp_angle_known
    all_stated = stated and strip.length_known
    return locate(
        image,
        optics.clamp_px,
        mask=mask,
        clamp_reach_px=3 * optics.clamp_sigma_px
        if all_stated
        else max(CLAMP_REACH_PX, 3 * optics.clamp_sigma_px),
        heading_rad=_heading_rad(optics) if stated else None,
        heading_sigma_rad=max(0.05, optics.clamp_angle_sigma_rad),
        signs=signs,
        length_px=strip.length_m * optics.px_per_m if strip.length_known else None,
        thickness_px=thickness_px,
    )


def _heading_rad(optics: Optics) -> float:
    """Return direction of the clamped sheet in the image: u right, v down."""
    start, angle = optics.clamp_m(), optics.clamp_angle_rad
    step = 10 / optics.px_per_m * np.array([math.cos(angle), math.sin(angle)])
    (u0, v0), (u1, v1) = optics.world_to_pixel([start, start + step])
    return math.atan2(v1 - v0, u1 - u0)
