"""Locate a strip of which little is known: its direction, length and thickness.

A path is searched at each of several widths, in an image reduced to it. The path whose two edges
change most, over the longest way, is the strip: a line inside a strip or along one of its edges
changes less, or is shorter.

A search that keeps few states shows which channels, widths and polarities may be the strip's at
all. One that keeps many follows it through gaps and past crossings; it is dear, and so only done
for those.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from labrig.vision.image.image import GreyImage
from labrig.vision.search.beam_paths import LONGER, ROUGH_STATES, Sought, path_from_clamp
from labrig.vision.search.edge_width import THINNEST_PX, measured_along
from labrig.vision.search.located import Located, aside_px, evidence_max
from labrig.vision.search.work import OutlineWork

WIDTH_STEP = 1.7  # from one width that is tried to the next
THICKEST_RATIO = 1 / 6  # of the length, and so of the image's side
NEAR_REACH_PX = 8.0  # a strip that begins further aside may be another one
COMPARABLE_RATIO = 0.15  # of a candidate's evidence to the clearest one's
LIKELY_RATIO = 0.5  # the same share of it for one that is only roughly known


@dataclass(frozen=True, eq=False, kw_only=True)
class Rough:
    """What a search of few states found in a channel, at a width and with a polarity."""

    image: GreyImage
    located: Located
    width: float
    sign: float
    reach: float


def rough_candidates(
    image: GreyImage, sought: Sought, work: OutlineWork, clearest: float = 0.0
) -> list[Rough]:
    """Return what may be the strip in one channel, and how clear it roughly is.

    What is far less clear than others, or than `clearest` of another channel, may be left out.
    """
    paths = []
    filled = image.filled()
    for width in widths_tried(image, sought.thickness_px, sought.length_px):
        ridges = sought.ridges(filled, width)
        for sign in sought.signs:
            for reach in (sought.clamp_reach_px, NEAR_REACH_PX):
                if not work.may_search_roughly():
                    break
                found = path_from_clamp(
                    ridges, sign, sought, width=width, reach=reach, states=ROUGH_STATES
                )
                if found is None:
                    break
                path = found.path_px
                paths.append((evidence_max(path, sought.clamp_px), path, width, sign, reach))
                if aside_px(path, sought.clamp_px) < NEAR_REACH_PX:
                    break  # else there may be another one that begins nearer
    rough: list[Rough] = []
    for most, path, width, sign, reach in sorted(paths, key=lambda each: -each[0]):
        if most < COMPARABLE_RATIO * LIKELY_RATIO * clearest:
            break  # nothing of it could be comparable
        one = measured_along(
            image, path, width, sign, fixed=sought.thickness_px, clamp=sought.clamp_px
        )
        if one is not None and one.worth > 0:
            rough.append(Rough(image=image, located=one, width=width, sign=sign, reach=reach))
            clearest = max(clearest, one.evidence)
    return rough


def searched_broadly(rough: Rough, sought: Sought) -> Located:
    """Return the strip that a search of many states finds where few have shown one.

    The clearer of both: the likeliest path need not be the one whose edges are clearest.
    """
    ridges = sought.ridges(rough.image.filled(), rough.width)
    found = None
    for longer in (1.0, LONGER):
        further = path_from_clamp(
            ridges, rough.sign, sought, width=rough.width, reach=rough.reach, longer=longer
        )
        found = further or found
        if found is None or not found.whole or sought.length_px is not None:
            break  # else it may be longer than the image is wide
    if found is None:
        return rough.located
    broad = measured_along(
        rough.image,
        found.path_px,
        rough.width,
        rough.sign,
        fixed=sought.thickness_px,
        clamp=sought.clamp_px,
    )
    if broad is None or broad.evidence <= rough.located.evidence:
        return rough.located
    return broad


def widths_tried(
    image: GreyImage, thickness_px: float | None, length_px: float | None
) -> Iterator[float]:
    """Yield the widths (pixels) to look for: the stated one, or from thin ones on."""
    if thickness_px is not None:
        yield max(THINNEST_PX, thickness_px)
        return
    most = THICKEST_RATIO * (min(image.grey.shape) if length_px is None else length_px)
    width = THINNEST_PX
    while width <= max(most, THINNEST_PX):
        yield width
        width *= WIDTH_STEP
