"""The likeliest path from the clamp at one width, up to where it is no longer seen."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.image.image import GreyImage
from labrig.vision.search.ridge_tracing import RidgeMaps, ridge_maps

FloatArray = npt.NDArray[np.float64]
MaskArray = npt.NDArray[np.uint8]
Point = tuple[float, float]

HEADINGS = 32  # all around
HEADING_SPREAD = (-2, -1, 0, 1, 2)  # around a stated one, in its standard deviations
ROUGH_STATES, BEAM_STATES = 120, 400  # that a search keeps: to rank what is tried, and to use
STEP_WIDTHS = 2.0  # a step of the search, in widths of the strip
LONGEST_STEPS = 220
LONGER = 2.0  # than the image's diagonal: a strip that turns back
BEND_QUANTUM_RAD = 0.045  # a coarse path bends in these, a step
GAIN_MIN = 0.25  # of a step that looks like the strip
END_RUN_STEPS = 4  # so many steps without it are its end
END_RUN_SHARE = 0.12  # or this share of what was followed, whichever is more
TURN_MAX_RAD = 5.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Sought:
    """What is stated of a strip; None: not known."""

    clamp_px: Point
    clamp_reach_px: float  # how far from there it may begin
    heading_rad: float | None
    heading_sigma_rad: float
    signs: tuple[float, ...]  # +1: brighter than what lies beside it
    length_px: float | None
    thickness_px: float | None
    mask: MaskArray | None = None  # (rows, columns): not 0 where something hides the view

    def ridges(self, filled: GreyImage, width_px: float) -> RidgeMaps:
        """Return the ridge maps at a width of an image without holes."""
        maps = ridge_maps(filled, width_px, wide=False)
        if self.mask is not None and self.mask.any():
            maps.hide(self.mask)
        return maps


@dataclass(frozen=True, eq=False, kw_only=True)
class BeamPath:
    """A path (raw pixels), and whether it was seen as far as it was looked for."""

    path_px: FloatArray
    whole: bool


def path_from_clamp(
    ridges: RidgeMaps,
    sign: float,
    sought: Sought,
    *,
    width: float,
    reach: float,
    states: int = BEAM_STATES,
    longer: float = 1.0,
) -> BeamPath | None:
    """Return the likeliest path up to where it ends; None without one.

    It begins within `reach` of the clamp. `longer`: by which it may be longer than the diagonal.
    """
    from labrig.vision.search.path_search import search

    scale = ridges.scale
    rows, columns = ridges.maps.shape[2:]
    step = STEP_WIDTHS * width / scale
    diagonal = math.hypot(rows, columns) * longer
    reach_px = diagonal if sought.length_px is None else sought.length_px / scale
    steps = int(np.clip(round(reach_px / step), 6, LONGEST_STEPS))
    step = reach_px / steps
    u0, v0 = (np.array(sought.clamp_px) + 0.5) / scale - 0.5
    beam = search(
        ridges.maps,
        sign,
        place=(float(u0), float(v0)),
        heading=sought.heading_rad or 0.0,
        spread=_spread(sought, reach / scale, max(1.0, 0.4 * width / scale)),
        steps=steps,
        straight_from=steps,
        wide_from=steps,
        length=step,
        most_bend=_most_bend(step, width / scale),
        most_turn=TURN_MAX_RAD,
        width=states,
        half=5.0,
        quantum=BEND_QUANTUM_RAD,
    )
    path, gains = beam.best()
    if len(path) == 0:
        return None
    first, end = _seen_part(gains)
    whole = end == steps
    if not whole:  # what lies beyond the end must not draw the path
        path, gains = beam.best(max(end, 4))
        first, end = _seen_part(gains)
    if end - first < 3:
        return None
    return BeamPath(path_px=ridges.raw(path[first : end + 1]), whole=whole)


def _spread(sought: Sought, reach: float, sideways: float) -> FloatArray:
    """Return (n, 3) the offsets and directions in which paths may start, in a map's pixels."""
    many = math.ceil(reach / sideways)
    offsets = np.arange(-many, many + 1) * sideways
    if sought.heading_rad is None:
        turns = np.arange(HEADINGS) * 2 * math.pi / HEADINGS
    else:
        turns = np.array(HEADING_SPREAD) * sought.heading_sigma_rad
    return np.array([(offset, turn, turn) for offset in offsets for turn in turns])


def _most_bend(step: float, width: float) -> int:
    """Return the tightest turn of a step that is tried, in quanta: a radius of two widths."""
    return int(np.clip(round(step / (2 * width) / BEND_QUANTUM_RAD), 3, 16))


def _seen_part(gains: FloatArray) -> tuple[int, int]:
    """Return first step and end of what looks like a strip: it ends where it is long unseen."""
    seen = gains > GAIN_MIN
    if not seen.any():
        return 0, 0
    first = int(np.argmax(seen))
    last, unseen = first, 0
    for at in range(first, len(gains)):
        unseen = 0 if seen[at] else unseen + 1
        if seen[at]:
            last = at
        elif unseen >= max(END_RUN_STEPS, END_RUN_SHARE * (at - first)):
            break
    return first, last + 1
