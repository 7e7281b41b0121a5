"""Find the end of a strip by its profile along the course: where it ceases to be the strip's.

Two things are compared with what they were shortly before, block by block along a curve: the
profile across (in all channels, with its signs), and how clear both edges are. So a strip that
fades or changes its colour slowly is followed. Each block says how much likelier it is that the
strip is there than that only its ground is; the strip ends where the sum of that is largest.
A leaf or a fitting at the tip has edges, but further apart, and another profile.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.fit.outline_blocks import Blocks
from labrig.vision.fit.outline_profiles import (
    BLUR_MIN_PX,
    BLUR_RATIO,
    greys_beside,
    running_middle,
    running_sum,
)
from labrig.vision.image.image import GreyImage
from labrig.vision.search.straightened import slopes
from labrig.vision.thresholds import (
    COURSE_SEEN_MIN,
    END_GAP_SHARE,
    END_GAP_WIDTHS,
)

FloatArray = npt.NDArray[np.float64]

BLOCK_RATIO, BLOCK_MIN_PX = 0.2, 2.0  # length of a block in widths, and at least
UNIT_RATIO, UNIT_MIN_PX = 0.08, 0.25  # step across
REACH_WIDTHS = 2.4  # how far across the image is looked at, to each side
HALF_WIDTHS = 0.9  # of the profile that is compared
SHIFT_WIDTHS = 0.3  # by which the strip may lie beside the curve
ASIDE_WIDTHS = 1.3  # from there on is the ground
EDGE_ROOM = 0.25  # of an edge about its place, in widths
WIDER = (1.7, 2.1, 2.6)  # in widths: edges of what is another thing
MEMORY_WIDTHS, MEMORY_SHARE = 8.0, 0.1  # of the length: how long a strip is remembered
MEMORY_MIN_BLOCKS, FIRST_MIN_BLOCKS = 8, 4
GROUND_WIDTHS = 3.0  # of the course in which the ground is taken to be alike
CROSSING_SAID_MAX = 12.0  # by all blocks together in which something else hides the strip
GOES_ON_SHARE = 0.4  # of the blocks of two widths beyond the end
LAST_BLOCK_LESS = 0.2  # a block counts as strip where it shows a third of it
ALIKE_WIDTHS = 0.8  # of blocks that share texture and blur
OUTSIDE_HALF_WIDTHS = 0.6  # of the strip that must lie inside the image


@dataclass(frozen=True, eq=False, kw_only=True)
class StripCourse:
    """What each block of a curve says of the strip; lengths in pixels of the sheet's plane."""

    block_px: float
    said: FloatArray  # (blocks,) log of the odds that the strip is there
    profile_said: FloatArray  # (blocks,) the part of it that the profile says
    edges_said: FloatArray  # (blocks,) and both edges
    backward: FloatArray  # (blocks,) as `said`, compared with what comes shortly after; or empty
    shift_px: FloatArray  # (blocks,) how far to the left the profile lies
    unlike: npt.NDArray[np.bool_]  # (blocks,) edges are there, of what looks different
    leaves_image: bool  # whether the curve leaves the image after the last block
    width_px: float
    hidden: npt.NDArray[np.bool_]  # (blocks,) by a mask or a roll: says nothing

    @property
    def end(self) -> tuple[float, float]:
        """Return where the strip ends along the curve, and the standard deviation of that."""
        total = np.cumsum(_with_crossings(self.said[: self._before_gap()]))
        share = max(1.0, ALIKE_WIDTHS * self.width_px / self.block_px)
        odds = np.exp((total - total.max()) / share)
        odds /= odds.sum()
        at = (np.arange(1, len(odds) + 1) - LAST_BLOCK_LESS) * self.block_px
        mean = float(odds @ at)
        spread = math.sqrt(float(odds @ (at - mean) ** 2) + self.block_px**2 / 12)
        return float(at[total.argmax()]), spread

    @property
    def goes_on(self) -> bool:
        """Whether something that looks different goes on where the strip ends."""
        first = round(self.end[0] / self.block_px)
        after = self.unlike[first : first + max(3, round(2 * self.width_px / self.block_px))]
        return bool(len(after) and after.mean() > GOES_ON_SHARE)

    @property
    def hidden_beyond_px(self) -> float:
        """How far what hides the strip reaches from where it is seen to end."""
        after = self.hidden[math.ceil(self.end[0] / self.block_px) :]
        shown = np.flatnonzero(~after)
        return float(shown[0] if len(shown) else len(after)) * self.block_px

    def begin(self, most_px: float) -> float:
        """Return where the strip begins to look as it does, at most so far along the curve."""
        few = int(most_px / self.block_px)
        at_end = np.cumsum(self.backward[:few][::-1])
        return float(few - 1 - at_end.argmax()) * self.block_px if few and at_end.max() > 0 else 0.0

    @property
    def total_px(self) -> float:
        """Length that was looked at."""
        return len(self.said) * self.block_px

    def _before_gap(self) -> int:
        """Return how many blocks lie before a long gap: beyond it may be another thing."""
        unseen = 0
        for at, said in enumerate(self.said):
            unseen = 0 if said > 0 else unseen + (not self.hidden[at])
            longest = max(END_GAP_WIDTHS * self.width_px / self.block_px, END_GAP_SHARE * at)
            if unseen > longest:
                return max(1, at + 1)
        return max(1, len(self.said))


def _with_crossings(said: FloatArray) -> FloatArray:
    """Return log odds of blocks whose runs without the strip count no more than one crossing.

    What lies across the strip hides many blocks at once; each says the same.
    """
    said = said.copy()
    run = 0.0
    for at, each in enumerate(said):
        run = min(run + each, 0.0) if each < 0 else 0.0
        if run < -CROSSING_SAID_MAX:
            said[at] = min(0.0, each - (run + CROSSING_SAID_MAX))
            run = -CROSSING_SAID_MAX
    return said


def course_along(
    shape: CurveShape,
    images: Sequence[GreyImage],
    optics: Optics,
    width_px: float,
    *,
    taper: FloatArray | None = None,
    backward: bool = False,
) -> StripCourse:
    """Return what the image shows of the strip along a curve that may be longer than it.

    `backward`: where it begins, too; its end is known then.
    """
    step = shape.basis.step_px
    many = max(1, round(max(BLOCK_MIN_PX, BLOCK_RATIO * width_px) / step))
    unit = max(UNIT_MIN_PX, UNIT_RATIO * width_px)
    places = math.ceil(REACH_WIDTHS * width_px / unit)
    across = np.asarray(np.arange(-places, places + 1) * unit, dtype=np.float64)
    size, finite = signed_sizes(shape, images, optics, across, many, width_px, taper)
    in_frame = _in_frame(shape, images[0], optics, many, width_px)
    outside, hidden = ~finite & ~in_frame, ~finite & in_frame
    # a clamp may lie at the border
    first_out = next((at for at in range(len(finite) // 4, len(finite)) if outside[at]), None)
    hidden = hidden[:first_out]
    size = _without_hidden(size[:first_out], hidden)
    said = _said(size, across, width_px, many * step)
    said[:, hidden] = 0.0
    return StripCourse(
        block_px=many * step,
        said=said[0],
        profile_said=said[1],
        edges_said=said[2],
        backward=_said(size[::-1, :, ::-1], across, width_px, many * step)[0][::-1]
        if backward
        else np.empty(0),
        shift_px=said[3],
        unlike=said[4] > 0,
        leaves_image=first_out is not None,
        width_px=width_px,
        hidden=hidden,
    )


def _in_frame(
    shape: CurveShape, image: GreyImage, optics: Optics, many: int, width_px: float
) -> npt.NDArray[np.bool_]:
    """Return (blocks,) whether the strip along a curve lies inside the image, hidden or not."""
    rows, columns = image.grey.shape
    left = np.stack([-np.sin(shape.phi), np.cos(shape.phi)], axis=1)
    middle = np.stack([shape.x, shape.y], axis=1)
    inside = np.ones(len(middle), dtype=bool)
    for side in (-OUTSIDE_HALF_WIDTHS, 0.0, OUTSIDE_HALF_WIDTHS):
        places = optics.world_to_pixel((middle + side * width_px * left) / optics.px_per_m)
        inside &= ((places >= 0) & (places <= (columns - 1, rows - 1))).all(axis=1)
    blocks = max(1, len(middle) // many)
    return np.asarray(inside[: blocks * many].reshape(blocks, -1).all(axis=1))


def _without_hidden(size: FloatArray, hidden: npt.NDArray[np.bool_]) -> FloatArray:
    """Return slopes (blocks, ...) with those shortly before in place of what is hidden."""
    if not hidden.any() or hidden.all():
        return size
    shown = np.flatnonzero(~hidden)
    before = np.searchsorted(shown, np.arange(len(hidden)), side="right") - 1
    return np.asarray(size[shown[np.maximum(before, 0)]])


def completed(course: StripCourse, blocks: Blocks, step_px: float) -> Blocks:
    """Return blocks with those, too, in which only the whole profile shows the strip."""
    at = ((blocks.node * step_px) / course.block_px).astype(np.int64)
    there = at < len(course.said)
    at = np.minimum(at, len(course.said) - 1)
    # of one edge alone it is not known which one it is
    few = max(1, round(course.width_px / course.block_px))
    faint = running_sum(course.edges_said, few) > 0
    added = there & ~blocks.seen & faint[at] & (course.profile_said[at] >= COURSE_SEEN_MIN)
    if not added.any() or not blocks.seen.any():
        return blocks
    usual = float(np.median(blocks.width_px[blocks.seen]))
    return replace(
        blocks,
        middle_px=np.where(added, course.shift_px[at], blocks.middle_px),
        width_px=np.where(added, usual, blocks.width_px),
        seen=blocks.seen | added,
        by_profile=added,
    )


def signed_sizes(
    shape: CurveShape,
    images: Sequence[GreyImage],
    optics: Optics,
    across: FloatArray,
    many: int,
    width_px: float,
    taper: FloatArray | None,
) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """Return (blocks, channels, across) the image's slope over texture, and where it is seen.

    It is NaN outside of the image, and under a mask.
    """
    unit = float(across[1] - across[0])
    blur = max(BLUR_MIN_PX, BLUR_RATIO * width_px) / unit
    aside = np.abs(across) > 0.5 * (ASIDE_WIDTHS + HALF_WIDTHS) * width_px
    middle = np.abs(across) < OUTSIDE_HALF_WIDTHS * width_px
    found = []
    inside = np.ones(max(1, len(shape.x) // many), dtype=bool)
    greys = greys_beside(shape, images, optics, across, taper)
    for image, grey in zip(images, greys, strict=True):
        rows = grey[: len(inside) * many]
        with np.errstate(invalid="ignore"):
            profiles = rows.reshape(len(inside), -1, len(across)).mean(axis=1)
        inside &= np.isfinite(profiles[:, middle]).all(axis=1)
        slope = slopes(profiles, blur)
        texture = float(np.median(np.abs(slope[:, aside]))) / 0.6745
        pixels = 1.5 * image.noise / math.sqrt(many * shape.basis.step_px * blur * unit)
        found.append(slope / max(texture, pixels, 1e-9))
    return np.stack(found, axis=1), inside


def _said(size: FloatArray, across: FloatArray, width: float, block_px: float) -> FloatArray:
    """Return (5, blocks) log odds of all, of profile, of edges, the profile's shift, unlike."""
    from labrig.vision.fit.course_odds import SHIFT, log_odds  # numba is slow to import

    unit, count = float(across[1] - across[0]), len(size)
    half, few, far = (
        round(widths * width / unit) for widths in (HALF_WIDTHS, SHIFT_WIDTHS, ASIDE_WIDTHS)
    )
    edges, ground, wider = _edges(size, across, width, block_px)
    memory = max(
        MEMORY_MIN_BLOCKS, max(MEMORY_WIDTHS * width, MEMORY_SHARE * count * block_px) / block_px
    )
    first = int(max(FIRST_MIN_BLOCKS, min(count // 8, memory)))
    middle = len(across) // 2
    told: FloatArray = log_odds(
        np.ascontiguousarray(size),
        np.median(size[:first, :, middle - half : middle + half + 1], axis=0),
        edges,
        float(np.median(edges[:first])),
        ground,
        wider,
        few=few,
        far=far,
        memory=float(memory),
        near=2 * max(6, round(GROUND_WIDTHS * width / block_px)),
    )
    told[SHIFT] *= unit
    return told


def _edges(
    size: FloatArray, across: FloatArray, width: float, block_px: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (blocks,) the weaker edge of the strip, of its ground, and of what is wider."""
    root = np.sqrt((size**2).mean(axis=1))

    def pair(centre: float, wide: float, room: float) -> FloatArray:
        low, high = (
            root[:, np.abs(across - centre - side * wide) <= room].max(axis=1)
            for side in (-0.5, 0.5)
        )
        return np.asarray(np.minimum(low, high))

    room = EDGE_ROOM * width + 0.01
    strip = np.maximum(pair(0.0, width, room), 1e-3)
    beside = [pair(centre * width, width, room) for centre in (-1.5, 1.5)]
    ground = np.log(np.maximum(np.median(beside, axis=0), 0.3))
    ground = running_middle(ground, max(2, round(2 * width / block_px)))
    wider = np.max([pair(0.0, ratio * width, 0.2 * width + 0.01) for ratio in WIDER], axis=0)
    return strip, np.exp(ground), wider
