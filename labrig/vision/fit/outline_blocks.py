"""Both edges of a strip beside a curve, block by block.

Blocks are about as long as the strip is thick. The way through their shifts that shows both edges
best is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.fit.outline_profiles import (
    EDGE_ROOM_RATIO,
    SHIFT_RATIO,
    across_px,
    edge_sizes,
    running_middle,
    running_sum,
)
from labrig.vision.image.image import GreyImage
from labrig.vision.thresholds import (
    OUTLINE_STRENGTH_MIN_RATIO,
    OUTLINE_STRENGTH_MIN_SIGMAS,
    OUTLINE_WIDTH_RATIOS,
)

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]

BLOCK_RATIO = 0.3  # length of a block in widths
BLOCK_MIN_PX = 3.0
SHIFT_COST = 6.0  # of a shift by one width from block to block, squared
FRAY_HALF_BLOCKS = 4
# a strip of a few pixels may become thinner by this, though by no more than to this share, where
# its edges are as clear as this
THINNER_PX, THINNER_RATIO, THINNER_MIN_SIGMAS = 2.4, 0.4, 10.0
FRAY_WIDTH_RATIO, FRAY_WIDTH_PX = 0.12, 1.0  # by which a block's width may leave its neighbours'
FRAY_SIGMAS = 4.0  # or so many of their scatter
LONELY_HALF_BLOCKS, LONELY_SHARE = 5, 0.5  # around a block, seen


@dataclass(frozen=True, eq=False, kw_only=True)
class Blocks:
    """What is seen of both edges, block by block; lengths in pixels of the sheet's plane."""

    node: IntArray  # (blocks,): the curve's node at its middle
    middle_px: FloatArray  # to the left of the curve
    width_px: FloatArray
    strength: FloatArray  # the change at the weaker edge, over noise and texture
    clear: BoolArray  # whether both edges are, however far apart they lie
    seen: BoolArray
    by_profile: BoolArray  # seen by the whole profile only, for an edge is too faint

    @property
    def by_edges(self) -> BoolArray:
        """(blocks,) whether both edges are seen, so that a width is measured."""
        return np.asarray(self.seen & ~self.by_profile)

    def longest_gap_px(self, step_px: float) -> float:
        """Return the length on which no block shows both edges, at most."""
        at = np.concatenate([[-1], np.flatnonzero(self.seen), [len(self.seen)]])
        many = float(np.median(np.diff(self.node)))
        return float(np.diff(at).max() - 1) * many * step_px


def measure_blocks(
    shape: CurveShape,
    images: Sequence[GreyImage],
    optics: Optics,
    width_px: float,
    taper: FloatArray,
) -> Blocks:
    """Return both edges beside a curve, block by block."""
    step = shape.basis.step_px
    many = max(1, round(max(BLOCK_MIN_PX, BLOCK_RATIO * width_px) / step))
    across = across_px(width_px)
    unit = float(across[1] - across[0])
    size = edge_sizes(shape, images, optics, width_px, many, taper=taper)
    count = len(size)
    node = np.minimum((np.arange(count) + 0.5) * many, len(shape.x) - 1).astype(np.int64)
    shift = _best_way(_pair(size, width_px / unit, SHIFT_RATIO * width_px / unit), width_px / unit)
    room = EDGE_ROOM_RATIO * width_px
    low, weak = _edge(size, shift * unit - width_px / 2, room, across)
    high, other = _edge(size, shift * unit + width_px / 2, room, across)
    strength = np.minimum(weak, other)
    wide = high - low
    usual = float(np.median(strength))
    least, most = OUTLINE_WIDTH_RATIOS
    clear = strength > OUTLINE_STRENGTH_MIN_RATIO * usual
    clear &= strength > OUTLINE_STRENGTH_MIN_SIGMAS
    thinner = wide > max(THINNER_RATIO * width_px, width_px - THINNER_PX)
    thinner &= strength > THINNER_MIN_SIGMAS
    wide_enough = (wide > least * width_px) | thinner
    seen = clear & wide_enough & (wide < most * width_px)
    # a fitting or a fray shows on one side of few blocks only
    around = running_middle(wide, FRAY_HALF_BLOCKS)
    frayed = max(FRAY_WIDTH_RATIO * width_px + FRAY_WIDTH_PX, FRAY_SIGMAS * roughness(wide))
    seen &= np.abs(wide - around) < frayed
    return Blocks(
        node=node,
        middle_px=0.5 * (low + high) * taper[node],
        width_px=wide * taper[node],
        strength=strength,
        clear=clear,
        seen=seen,
        by_profile=np.zeros(count, dtype=bool),
    )


def without_lonely(blocks: Blocks) -> Blocks:
    """Return blocks without those that are seen where most others are not.

    Dirt shows two edges here and there: a path that cuts off a bend is no better known for it.
    """
    many = running_sum(blocks.seen, LONELY_HALF_BLOCKS)
    there = running_sum(np.ones(len(blocks.seen)), LONELY_HALF_BLOCKS)
    kept = many >= LONELY_SHARE * there
    return replace(blocks, seen=blocks.seen & kept, by_profile=blocks.by_profile & kept)


def _pair(size: FloatArray, apart: float, reach: float) -> FloatArray:
    """Return (blocks, shifts) the weaker change of two edges that far apart."""
    middle = size.shape[1] // 2
    shifts = np.arange(-int(reach), int(reach) + 1)
    low = np.round(middle + shifts - apart / 2).astype(int)
    high = np.round(middle + shifts + apart / 2).astype(int)
    return np.asarray(np.minimum(size[:, low], size[:, high]))


def _best_way(score: FloatArray, width: float) -> FloatArray:
    """Return (blocks,) the shifts (steps) that show the edges best and change little."""
    blocks, many = score.shape
    score = score / max(float(np.median(score.max(axis=1))), 1e-9)
    score = np.minimum(score, 2.0)
    apart = (np.arange(many)[:, None] - np.arange(many)[None, :]) / width
    cost = SHIFT_COST * (4 * apart) ** 2
    total, came = score[0].copy(), np.zeros((blocks, many), dtype=np.int64)
    for b in range(1, blocks):
        options = total[None, :] - cost
        came[b] = options.argmax(axis=1)
        total = score[b] + options[np.arange(many), came[b]]
    way = np.empty(blocks, dtype=np.int64)
    way[-1] = int(total.argmax())
    for b in range(blocks - 1, 0, -1):
        way[b - 1] = came[b, way[b]]
    return np.asarray(way - many // 2, dtype=np.float64)


def _edge(
    size: FloatArray, place: FloatArray, room: float, across: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return (blocks,) place and size of the largest change near a place, to a part of a step."""
    near = np.abs(across[None, :] - place[:, None]) <= room
    near[:, [0, -1]] = False
    peak = np.where(near, size, -1.0).argmax(axis=1)
    peak = np.clip(peak, 1, len(across) - 2)
    rows = np.arange(len(size))
    before, at, after = (size[rows, peak + q] for q in (-1, 0, 1))
    bend = before - 2 * at + after
    beside = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1.0), 0.0)
    unit = float(across[1] - across[0])
    return across[peak] + np.clip(beside, -1, 1) * unit, at


def roughness(values: FloatArray) -> float:
    """Return the robust standard deviation of values about their running middle."""
    if len(values) < 5:
        return float(np.std(values))
    middle = running_middle(values, 2)
    return 1.48 * float(np.median(np.abs(values - middle))) * math.sqrt(1.25)
