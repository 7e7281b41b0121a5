"""Locate a strip of which little is known: its direction, length and thickness.

A path is searched at each of several widths, in an image reduced to it. The path whose two edges
change most, over the longest way, is the strip: a line inside a strip or along one of its edges
changes less, or is shorter.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.image.image import GreyImage
from labrig.vision.search.ridge_tracing import RidgeMaps, ridge_maps
from labrig.vision.search.straightened import (
    resampled,
    slopes,
    smoothed,
    straightened,
)
from labrig.vision.search.work import OutlineWork
from labrig.vision.thresholds import END_PRESENT_RATIO

FloatArray = npt.NDArray[np.float64]
MaskArray = npt.NDArray[np.uint8]
Point = tuple[float, float]

WIDTH_STEP = 1.7  # from one width that is tried to the next
THINNEST_PX = 2.5
THICKEST_RATIO = 1 / 6  # of the length, and so of the image's side
HEADINGS = 32  # all around
HEADING_SPREAD = (-2, -1, 0, 1, 2)  # around a stated one, in its standard deviations
BEAM_WIDTH = 400  # states that a search keeps
STEP_WIDTHS = 2.0  # a step of the search, in widths of the strip
LONGEST_STEPS = 220
LONGER = 2.0  # than the image's diagonal: a strip that turns back
BEND_QUANTUM_RAD = 0.045  # a coarse path bends in these, a step
GAIN_MIN = 0.25  # of a step that looks like the strip
END_RUN_STEPS = 4  # so many steps without it are its end
END_RUN_SHARE = 0.12  # or this share of what was followed, whichever is more
TURN_MAX_RAD = 5.5
WIDTHS_COMPARED = 19
ONE_EDGE_BLURS = 6.0  # two edges further apart than so many blurs are not one
STATED_WIDTH_RATIOS = (0.75, 1.45)  # of the width that is seen to one that is stated
EDGE_BLUR_RATIO = 0.12  # of the width: what an edge is smoothed by
CLEARNESS_OF_NOTHING = 2.0  # of the largest changes that noise makes along any path
CLEARNESS_OF_ANY = 20.0  # on a plain ground every strip is clear
SCALE_SPREAD = 0.5  # of the logarithm of a path's width to that at which it was searched
NEAR_REACH_PX = 8.0  # a strip that begins further aside may be another one
ASIDE_USUAL_PX = 5.0  # from where the clamp is stated to the strip's begin
COMPARABLE_RATIO = 0.15  # of a candidate's evidence to the clearest one's
BORDER_PX = 10.0  # a strip that leaves the image is followed up to here


@dataclass(frozen=True, eq=False, kw_only=True)
class Located:
    """A strip found roughly; all in the image's pixels."""

    path_px: FloatArray  # (n, 2), from where it begins to its end
    thickness_px: float
    edge: float  # grey levels: what the two edges change by, in the mean
    leaves_image: bool
    sign: float  # +1: brighter than what lies beside it
    likeness: float = 1.0  # 0 to 1: how alike both sides of it are, against its edges
    clearness: float = 0.0  # its edges over what changes beside it
    scale_px: float = 0.0  # the width at which its path was searched; 0: it was not
    aside_px: float = 0.0  # from the stated place to where it begins

    @property
    def length_px(self) -> float:
        """Length of the path."""
        return float(np.hypot(*np.diff(self.path_px, axis=0).T).sum())

    @property
    def worth(self) -> float:
        """How much speaks for it: the longer and the clearer, the more.

        The same ground lies to both sides of a strip, and not of its rim or of half of it.
        """
        return self.edge * self._share_px

    @property
    def evidence(self) -> float:
        """The same over what noise and texture show: to compare channels with."""
        clear = min(self.clearness - CLEARNESS_OF_NOTHING, CLEARNESS_OF_ANY)
        return max(clear, 0.01) * self._share_px

    @property
    def _share_px(self) -> float:
        near = _nearness(self.aside_px)
        # a path that was searched at another width than it shows is a rough one
        apart = math.log(self.thickness_px / self.scale_px) if self.scale_px else 0.0
        fitting = math.exp(-0.5 * (apart / SCALE_SPREAD) ** 2)
        return self.length_px * self.likeness**2 * near * fitting


def candidates(
    image: GreyImage,
    clamp_px: Point,
    *,
    mask: MaskArray | None = None,
    clamp_reach_px: float,
    heading_rad: float | None,
    heading_sigma_rad: float,
    signs: tuple[float, ...],
    length_px: float | None,
    thickness_px: float | None,
    work: OutlineWork,
    clearest_before: float = 0.0,
) -> list[Located]:
    """Return what may be the strip that begins near a place, the clearest first.

    What is far less clear than others, or than `clearest_before` of another channel, may be left
    out.

    Near: within `clamp_reach_px`. What is None is not known. `signs`: the polarities to try;
    `mask` (rows, columns): not 0 where something hides the view.
    """
    paths = []
    filled = image.filled()
    for width in widths_tried(image, thickness_px, length_px):
        ridges = ridge_maps(filled, width, wide=False)
        if mask is not None and mask.any():
            ridges.hide(mask)
        for sign in signs:
            for reach in (clamp_reach_px, NEAR_REACH_PX):
                path = _path(
                    ridges,
                    sign,
                    work=work,
                    width=width,
                    clamp=clamp_px,
                    reach=reach,
                    heading=heading_rad,
                    heading_sigma=heading_sigma_rad,
                    length_px=length_px,
                )
                if path is None:
                    break
                paths.append((_evidence_max(path, clamp_px), path, width, sign))
                if _aside_px(path, clamp_px) < NEAR_REACH_PX:
                    break  # else there may be another one that begins nearer
    found: list[Located] = []
    clearest = clearest_before
    for most, path, width, sign in sorted(paths, key=lambda each: -each[0]):
        if most < COMPARABLE_RATIO * clearest:
            break  # nothing of it could be comparable
        one = measured_along(image, path, width, sign, fixed=thickness_px, clamp=clamp_px)
        if one is not None and one.worth > 0:
            found.append(one)
            clearest = max(clearest, one.evidence)
    return sorted(found, key=lambda each: -each.evidence)


def _aside_px(path: FloatArray, clamp: Point) -> float:
    return float(np.hypot(*(path - np.array(clamp)).T).min())


def _evidence_max(path: FloatArray, clamp: Point) -> float:
    """Return the most that a path's evidence can be, before its edges are measured."""
    length = float(np.hypot(*np.diff(path, axis=0).T).sum())
    return CLEARNESS_OF_ANY * length * _nearness(_aside_px(path, clamp))


def _nearness(aside_px: float) -> float:
    return math.exp(-0.5 * (aside_px / ASIDE_USUAL_PX) ** 2)


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


def _path(
    ridges: RidgeMaps,
    sign: float,
    *,
    work: OutlineWork,
    width: float,
    clamp: Point,
    reach: float,
    heading: float | None,
    heading_sigma: float,
    length_px: float | None,
    longer: float = 1.0,
) -> FloatArray | None:
    """Return the likeliest path (raw pixels) up to where it ends; None without one."""
    from labrig.vision.search.path_search import search

    if not work.may_search():
        return None
    scale = ridges.scale
    rows, columns = ridges.maps.shape[2:]
    step = STEP_WIDTHS * width / scale
    reach_px = (math.hypot(rows, columns) if length_px is None else length_px / scale) * longer
    steps = int(np.clip(round(reach_px / step), 6, LONGEST_STEPS))
    step = reach_px / steps
    sideways = max(1.0, 0.4 * width / scale)
    many = math.ceil(reach / scale / sideways)
    offsets = np.arange(-many, many + 1) * sideways
    if heading is None:
        turns = np.arange(HEADINGS) * 2 * math.pi / HEADINGS
    else:
        turns = np.array(HEADING_SPREAD) * heading_sigma
    spread = np.array([(offset, turn, turn) for offset in offsets for turn in turns])
    u0, v0 = (np.array(clamp) + 0.5) / scale - 0.5

    beam = search(
        ridges.maps,
        sign,
        place=(float(u0), float(v0)),
        heading=heading or 0.0,
        spread=spread,
        steps=steps,
        straight_from=steps,
        wide_from=steps,
        length=step,
        most_bend=_most_bend(step, width / scale),
        most_turn=TURN_MAX_RAD,
        width=BEAM_WIDTH,
        half=5.0,
        quantum=BEND_QUANTUM_RAD,
    )
    path, gains = beam.best()
    if len(path) == 0:
        return None
    first, end = _seen_part(gains)
    if end == steps and length_px is None and longer == 1.0:  # longer than the image is wide
        further = _path(
            ridges,
            sign,
            work=work,
            width=width,
            clamp=clamp,
            reach=reach,
            heading=heading,
            heading_sigma=heading_sigma,
            length_px=None,
            longer=LONGER,
        )
        if further is not None:
            return further
    if end < steps:  # what lies beyond the end must not draw the path
        path, gains = beam.best(max(end, 4))
        first, end = _seen_part(gains)
    if end - first < 3:
        return None
    return ridges.raw(path[first : end + 1])


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


def measured_along(
    image: GreyImage,
    path: FloatArray,
    width: float,
    sign: float,
    *,
    fixed: float | None,
    clamp: Point,
) -> Located | None:
    """Return a path with the thickness that its edges show."""
    step = max(1.0, 0.25 * width)
    line = smoothed(resampled(path, step), round(2 * width / step))
    line, leaves = _inside(line, image.grey.shape)
    if len(line) < 8:
        return None
    unit = max(0.5, 0.1 * width)
    across = np.arange(-3.2 * width, 3.2 * width + unit / 2, unit)
    many = max(1, round(width / step))
    strip = straightened(image.grey, line, across)
    blocks = len(strip) // many
    if blocks < 4:
        return None
    rows = strip[: blocks * many].reshape(blocks, many, -1)
    profiles = rows.mean(axis=1)
    found = []
    low, high = (0.4, 2.2) if fixed is None else STATED_WIDTH_RATIOS
    slope, slope_blur = profiles, 0.0
    for wide in (fixed or width) * np.geomspace(low, high, WIDTHS_COMPARED):
        blur = max(0.8, EDGE_BLUR_RATIO * wide) / unit
        if max(blur, 1.0) != slope_blur:  # thin ones are all looked at through the same filter
            slope_blur = max(blur, 1.0)
            slope = slopes(profiles, slope_blur)
        edges = _both_edges(
            slope, wide / unit, 0.7 * width / unit, opposite=wide < ONE_EDGE_BLURS * blur * unit
        )
        edges = edges[: _end_block(edges)]
        found.append((float(np.minimum(edges, 2 * np.median(edges)).sum()), edges, wide, slope))
    _, edges, wide, slope = max(found, key=lambda each: each[0])
    if len(edges) < 4:
        return None
    beside = np.abs(slope[: len(edges), np.abs(across) > 1.2 * wide])
    texture = max(float(np.median(beside)) / 0.6745 if beside.size else 0.0, 1e-3)
    clear = float(np.mean(np.minimum(edges, 2 * np.median(edges))))
    if len(edges) < blocks:
        line, leaves = line[: len(edges) * many + 1], False
        profiles = profiles[: len(edges)]
    return Located(
        path_px=line,
        thickness_px=float(wide),
        edge=clear,
        leaves_image=leaves,
        sign=sign,
        clearness=clear / texture,
        likeness=_likeness(profiles, across, float(wide)),
        aside_px=_aside_px(line, clamp),
        scale_px=max(width, THINNEST_PX),
    )


def _end_block(edges: FloatArray) -> int:
    """Return how many blocks show the strip: a path goes on beyond its end.

    Up to the end its edges are there, beyond it they are not: the place where that is truest.
    """
    usual = float(np.median(edges[: max(END_RUN_STEPS, len(edges) // 8)]))
    there = np.minimum(edges / max(usual, 1e-9), 1.0) - END_PRESENT_RATIO
    at = np.arange(len(there))
    unseen = at - np.maximum.accumulate(np.where(there > 0, at, -1))
    lost = unseen > np.maximum(END_RUN_STEPS, END_RUN_SHARE * at)
    if lost.any():
        there = there[: int(lost.argmax()) + 1]
    return int(np.cumsum(there).argmax()) + 1


def _likeness(profiles: FloatArray, across: FloatArray, wide: float) -> float:
    """Return how alike the ground to both sides is, against how the strip differs from it."""
    out = (np.abs(across) > 0.6 * wide) & (np.abs(across) < 0.6 * wide + max(2.0, 0.3 * wide))
    left, right = (_mean(profiles[:, out & (sign * across > 0)]) for sign in (-1, 1))
    inside = _mean(profiles[:, np.abs(across) < 0.4 * wide])
    apart = np.abs(left - right)
    differs = np.abs(inside - left) + np.abs(inside - right)
    return float(1 - np.median(apart / np.maximum(np.maximum(differs, apart), 1e-9)))


def _mean(values: FloatArray) -> FloatArray:
    return np.asarray(np.where(np.isfinite(values), values, 0.0).mean(axis=1))


def _inside(line: FloatArray, shape: tuple[int, ...]) -> tuple[FloatArray, bool]:
    """Return a line up to where it comes near the border, and whether it does."""
    room = np.minimum(line, np.array([shape[1], shape[0]]) - 1 - line).min(axis=1)
    near = np.flatnonzero(room < BORDER_PX)
    begin = len(line) // 4  # a clamp may lie at the border
    late = near[near > begin]
    if len(late) == 0:
        return line, False
    return line[: late[0]], True


def _both_edges(slope: FloatArray, apart: float, reach: float, *, opposite: bool) -> FloatArray:
    """Return (blocks,) the clearest pair of edges that far apart: the weaker counts more.

    `opposite`: only a rise with a fall, for two places on one blurred edge are no pair.
    """
    middle = slope.shape[1] // 2
    half = apart / 2
    shifts = np.arange(-int(reach), int(reach) + 1)
    low = np.clip(np.round(middle + shifts - half).astype(int), 0, slope.shape[1] - 1)
    high = np.clip(np.round(middle + shifts + half).astype(int), 0, slope.shape[1] - 1)
    weaker = np.minimum(np.abs(slope[:, low]), np.abs(slope[:, high]))
    if opposite:
        weaker = np.where(slope[:, low] * slope[:, high] < 0, weaker, 0.0)
    return np.asarray(weaker.max(axis=1))
