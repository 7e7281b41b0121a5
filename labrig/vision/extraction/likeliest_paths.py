"""Which paths in an image may be the strip, the likeliest first: over all channels and widths."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import StripGeometry
from labrig.vision.image.image import GreyImage
from labrig.vision.search.beam_paths import Sought
from labrig.vision.search.locate import (
    COMPARABLE_RATIO,
    LIKELY_RATIO,
    Rough,
    rough_candidates,
    searched_broadly,
)
from labrig.vision.search.located import Located
from labrig.vision.search.stated_places import locate_through
from labrig.vision.search.straightened import distances, resampled
from labrig.vision.search.work import OutlineWork

MaskArray = npt.NDArray[np.uint8]

CLAMP_REACH_PX = 20.0  # how far from the stated place an unknown strip may begin
OF_A_CHANNEL_MAX, FITTED_MAX = 2, 4  # candidates: each costs a fit
SAME_WIDTHS, SAME_MIN_PX = 0.5, 2.0  # beside another path everywhere: the same course
SAME_THICKNESS = 1.35  # of one path's thickness to another's, at most


def likeliest_first(
    images: Sequence[GreyImage],
    optics: Optics,
    strip: StripGeometry,
    mask: MaskArray,
    work: OutlineWork,
) -> list[Located]:
    """Return what the channels show, without what is far less clear than the clearest."""
    if optics.stated_places_px:
        found = _through_places(images, optics, strip, mask)
    else:
        found = _from_clamp(images, _sought(optics, strip, mask), work)
    found.sort(key=lambda each: -each.evidence)
    return [each for each in found if each.evidence > COMPARABLE_RATIO * found[0].evidence][
        :FITTED_MAX
    ]


def _from_clamp(images: Sequence[GreyImage], sought: Sought, work: OutlineWork) -> list[Located]:
    """Return the strips that lead away from the clamp: at most so many of a channel."""
    rough: list[Rough] = []
    for image in images:
        work.next_channel()
        clearest = max((each.located.evidence for each in rough), default=0.0)
        rough += rough_candidates(image, sought, work, clearest)
    found: list[tuple[GreyImage, Located]] = []
    clearest = 0.0
    for each in sorted(rough, key=lambda each: -each.located.evidence):
        of_channel = [one for image, one in found if image is each.image]
        if each.located.evidence < COMPARABLE_RATIO * LIKELY_RATIO * clearest:
            break
        if len(of_channel) == OF_A_CHANNEL_MAX or any(_alike(each.located, o) for o in of_channel):
            continue
        if not work.may_search_broadly():
            break
        located = searched_broadly(each, sought)
        if not any(_alike(located, o) for o in of_channel):
            found.append((each.image, located))
            clearest = max(clearest, located.evidence)
    return [located for _, located in found]


def _alike(one: Located, other: Located) -> bool:
    """Return whether two paths are the same one, to a part of its thickness."""
    if not 1 / SAME_THICKNESS < one.thickness_px / other.thickness_px < SAME_THICKNESS:
        return False
    apart = distances(resampled(one.path_px, 3.0), resampled(other.path_px, 3.0))
    most = max(apart.min(axis=0).max(), apart.min(axis=1).max())
    return bool(most < max(SAME_WIDTHS * other.thickness_px, SAME_MIN_PX))


def _signs(optics: Optics) -> tuple[float, ...]:
    return {"bright": (1.0,), "dark": (-1.0,), "auto": (1.0, -1.0)}[optics.polarity]


def _through_places(
    images: Sequence[GreyImage], optics: Optics, strip: StripGeometry, mask: MaskArray
) -> list[Located]:
    """Return the clearest strip of each channel through the stated places."""
    places = (optics.clamp_px, *optics.stated_places_px)
    thickness_px = strip.thickness_m * optics.px_per_m if strip.thickness_known else None
    found = [
        locate_through(image, places, mask=mask, signs=_signs(optics), thickness_px=thickness_px)
        for image in images
    ]
    return [each for each in found if each is not None]


def _sought(optics: Optics, strip: StripGeometry, mask: MaskArray) -> Sought:
    stated = optics.clamp_angle_known
    nearby = 3 * optics.clamp_sigma_px
    return Sought(
        clamp_px=optics.clamp_px,
        clamp_reach_px=nearby if stated and strip.length_known else max(CLAMP_REACH_PX, nearby),
        heading_rad=_heading_rad(optics) if stated else None,
        heading_sigma_rad=max(0.05, optics.clamp_angle_sigma_rad),
        signs=_signs(optics),
        length_px=strip.length_m * optics.px_per_m if strip.length_known else None,
        thickness_px=strip.thickness_m * optics.px_per_m if strip.thickness_known else None,
        mask=mask,
    )


def _heading_rad(optics: Optics) -> float:
    """Return direction of the clamped sheet in the image: u right, v down."""
    start, angle = optics.clamp_m(), optics.clamp_angle_rad
    step = 10 / optics.px_per_m * np.array([math.cos(angle), math.sin(angle)])
    (u0, v0), (u1, v1) = optics.world_to_pixel([start, start + step])
    return math.atan2(v1 - v0, u1 - u0)
