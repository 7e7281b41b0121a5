"""Look for a strip of which little is stated in the picture made smaller, too.

A strip does not end elsewhere, or lead elsewhere, because the picture is made smaller. Where it
seems to, one of both curves went on along another thing or stopped short, and its own sigma, which
is of edges that are clear, does not show that. So both must agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extraction.outline_curve import (
    TWO_WAYS,
    followed_outline,
    searched_outline,
)
from labrig.vision.extraction.outline_report import RIVAL_STEP, START_UNSEEN
from labrig.vision.image.downscaling import (
    downscaled_image,
    downscaled_optics,
    in_camera_pixels,
)
from labrig.vision.image.image import GreyImage
from labrig.vision.search.straightened import distances, resampled
from labrig.vision.thresholds import (
    IMAGE_SIDE_MIN_PX,
    SIZES_APART_MIN_PX,
    SIZES_APART_RATIO,
    SIZES_ENDS_APART_MIN_PX,
    SIZES_ENDS_APART_RATIO,
    SIZES_THICKNESS_RATIO,
)

FloatArray = npt.NDArray[np.float64]

SMALLER, SMALLEST = 0.7, 0.5  # of the picture's size
THINNEST_PX = 1.5  # of a strip in the smaller picture
STRAY_SHARE = 0.025  # of a path, which may lie anywhere: its end is looked at for itself
# refusals that name nothing that speaks against the curve: too little is seen in fewer pixels
UNSEEN = ("search failed", "check of the image failed", START_UNSEEN)

ENDS_APART = (
    "check of the end failed: the strip seems to end near {u:.0f},{v:.0f}, but in the picture made "
    "smaller near {other_u:.0f},{other_v:.0f}; click its tip (--tip-px), or state the length."
)
WAYS_APART = (
    "check of the course failed: in the picture made smaller another way leads away from the "
    "clamp, up to {apart:.0f} pixels beside this one; state places on the strip (--through) and "
    "its tip (--tip-px)."
)
REFUSED_SMALLER = (
    "check at another size failed: a curve was found, but not in the picture made smaller; state "
    "places on the strip (--through) and its tip (--tip-px). There, the {why}"
)
MADE_SMALLER = (
    "the picture as taken gave no curve; this one is that of the picture made smaller, and of one "
    "made smaller still"
)


def outline_curve(
    images: Sequence[GreyImage],
    optics: Optics,
    strip: StripGeometry,
    *,
    start: NeutralCurve | None = None,
) -> NeutralCurve:
    """Return the curve between the strip's edges, or why there is none.

    Where another size of the picture contradicts it, that is its doubt. `images`: the same one in
    each channel in which the strip may show, the likeliest first. `start`: the curve of an image
    shortly before.
    """
    if start is not None:
        followed = followed_outline(images, optics, strip, start)
        if followed.ok:
            return followed
    found = searched_outline(images, optics, strip)
    if strip.length_known or optics.stated_places_px:
        return found  # what is stated says which strip it is
    if found.why.startswith(RIVAL_STEP):
        return _found_smaller(images, optics, strip) or found
    if not found.ok:
        return found
    return replace(found, doubt=_contradicted(found, images, optics, strip))


def _contradicted(
    found: NeutralCurve, images: Sequence[GreyImage], optics: Optics, strip: StripGeometry
) -> str:
    """Return what another size of the picture says against a curve; empty: nothing."""
    if found.thickness_m * optics.px_per_m * SMALLER < THINNEST_PX:
        return ""
    smaller = _at_size(SMALLER, images, optics, strip)
    if smaller.ok:
        ratio = smaller.thickness_m / found.thickness_m
        if not 1 / SIZES_THICKNESS_RATIO < ratio < SIZES_THICKNESS_RATIO:
            return ""  # another thing, such as two strips that look like one
        return apart(found.points_px, smaller.points_px)
    if smaller.why != TWO_WAYS and smaller.why.startswith(UNSEEN):
        return ""
    return REFUSED_SMALLER.format(why=smaller.why)


def _found_smaller(
    images: Sequence[GreyImage], optics: Optics, strip: StripGeometry
) -> NeutralCurve | None:
    """Return the curve of a picture made smaller, where one made smaller still shows it, too.

    The second edge for which a strip is refused, of shade or of a face, is often finer than it.
    """
    smaller = _at_size(SMALLER, images, optics, strip)
    if not smaller.ok:
        return None
    smallest = _at_size(SMALLEST, images, optics, strip)
    if not smallest.ok or apart(smaller.points_px, smallest.points_px):
        return None
    return replace(smaller, warnings=(*smaller.warnings, MADE_SMALLER))


def _at_size(
    share: float, images: Sequence[GreyImage], optics: Optics, strip: StripGeometry
) -> NeutralCurve:
    """Return the curve of a picture of that share of the size, in pixels of the whole one."""
    if min(images[0].grey.shape) * share < IMAGE_SIDE_MIN_PX:
        return NeutralCurve(ok=False, why=UNSEEN[0])
    found = searched_outline(
        [downscaled_image(image, 1 / share) for image in images],
        downscaled_optics(optics, 1 / share),
        strip,
    )
    return in_camera_pixels(found, 1 / share)


def apart(path: FloatArray, other: FloatArray) -> str:
    """Return how two paths of one strip differ, as a sentence; empty where they agree."""
    path, other = resampled(path, 1.0), resampled(other, 1.0)
    away = distances(path, other)
    # one may be the first part of the other: its end says so
    aside = min(float(np.quantile(away.min(axis=k), 1 - STRAY_SHARE)) for k in (0, 1))
    ends = float(np.hypot(*(path[-1] - other[-1])))
    length = len(path) - 1.0
    if aside > max(SIZES_APART_MIN_PX, SIZES_APART_RATIO * length):
        return WAYS_APART.format(apart=aside)
    if ends > max(SIZES_ENDS_APART_MIN_PX, SIZES_ENDS_APART_RATIO * length):
        (u, v), (other_u, other_v) = path[-1], other[-1]
        return ENDS_APART.format(u=u, v=v, other_u=other_u, other_v=other_v)
    return ""
