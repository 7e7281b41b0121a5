"""Lead a curve on beyond where it leaves a strip, by how the strip looks shortly before.

A curve that is led on as it bends leaves a thin strip soon. The strip's profile across, in all
channels, is learned on the last part of the curve; beyond it the way is searched along which this
profile is found, to both sides and in any direction that a strip may take. It counts where no
other way shows nearly as much of this profile, or of the opposite one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.fit.course import (
    BLOCK_MIN_PX,
    BLOCK_RATIO,
    HALF_WIDTHS,
    UNIT_MIN_PX,
    UNIT_RATIO,
    signed_sizes,
)
from labrig.vision.image.image import GreyImage
from labrig.vision.thresholds import (
    COURSE_PROFILE_SIGMA_MIN,
    COURSE_STRIP_SPREAD,
    LED_ON_MIN_WIDTHS,
    LED_ON_OTHER_RATIO,
    LED_ON_SAID_MIN,
)

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

LEARNED_WIDTHS, LEARNED_MIN_BLOCKS = 6.0, 8  # of the last part of the curve
LEARNED_LEAST_BLOCKS = 4
LAST_WIDTHS = 1.5  # before its end: there it may have left the strip
SIDE_SHARE = 0.6  # of the length that is led on: so far aside it is looked
SLOPES = np.arange(-6, 7) * 0.15  # against the curve that is led on
BEND_COST = 0.4  # of a step of the slope from block to block
OTHER_WIDTHS = 1.6  # from the way: further aside are other things
OTHER_START_WIDTHS = 4.0  # beside the curve: there other ways may begin
START_BLOCKS = 0.5  # beside the curve: there the strip is
MIDDLE_SAID = 1.0  # by the place where the profile fits best
SAID_LEAST, SAID_MOST = -0.7, 2.0  # by one block


@dataclass(frozen=True, eq=False)
class LedOn:
    """A way beyond a curve's end: its slope against the curve that was led on."""

    s: FloatArray  # along that curve
    slope: FloatArray


def led_on_by_profile(
    shape: CurveShape, end_px: float, images: Sequence[GreyImage], optics: Optics, width_px: float
) -> LedOn | None:
    """Return the way on beyond `end_px` along a longer curve; None where the strip is not found."""
    step = shape.basis.step_px
    many = max(1, round(max(BLOCK_MIN_PX, BLOCK_RATIO * width_px) / step))
    block, unit = many * step, max(UNIT_MIN_PX, UNIT_RATIO * width_px)
    end = round(end_px / block)
    first = max(0, end - max(LEARNED_MIN_BLOCKS, round(LEARNED_WIDTHS * width_px / block)))
    known = end - first - round(LAST_WIDTHS * width_px / block)
    reach = SIDE_SHARE * (shape.basis.total_px - end_px) + HALF_WIDTHS * width_px
    across = np.asarray(np.arange(-math.ceil(reach / unit), math.ceil(reach / unit) + 1) * unit)
    tail = shape.from_node(first * many)
    size, inside = signed_sizes(tail, images, optics, across, many, width_px, None)
    half = round(HALF_WIDTHS * width_px / unit)
    far = np.abs(across[half : len(across) - half]) > HALF_WIDTHS * width_px
    if known < LEARNED_LEAST_BLOCKS or known >= len(size) or not far.any():
        return None
    strength = _strength(size, half, known)
    strength[~inside] = 0.0
    spread = max(1.48 * float(np.median(np.abs(strength[:, far]))), COURSE_PROFILE_SIGMA_MIN)
    said, opposite = (_said(sign * strength[known:], spread) for sign in (1, -1))
    way, found = _best_way(said, block / unit, START_BLOCKS * block / unit)
    at = np.asarray((first + known + 0.5 + np.arange(len(way))) * block, dtype=np.float64)
    if found < LED_ON_SAID_MIN or at[-1] < end_px + LED_ON_MIN_WIDTHS * width_px:
        return None
    other = _other_said(way, said, opposite, block_px=block, unit_px=unit, width_px=width_px)
    return None if found < LED_ON_OTHER_RATIO * other else LedOn(at, way)


def _strength(size: FloatArray, half: int, known: int) -> FloatArray:
    """Return (blocks, shifts) how much of the profile of the first `known` blocks is there."""
    windows = np.lib.stride_tricks.sliding_window_view(size, 2 * half + 1, axis=2)
    windows = windows.transpose(0, 2, 1, 3).reshape(len(size), windows.shape[2], -1)
    usual = np.median(windows[:known, windows.shape[1] // 2], axis=0)
    return np.asarray(windows @ usual / max(float(usual @ usual), 1e-12))


def _other_said(
    way: FloatArray,
    said: FloatArray,
    opposite: FloatArray,
    *,
    block_px: float,
    unit_px: float,
    width_px: float,
) -> float:
    """Return what any other way shows: of the opposite profile, or one that parts from this."""
    steps = block_px / unit_px
    beside = _beside(way, said.shape, steps, OTHER_WIDTHS * width_px / unit_px)
    chance = np.where(beside, opposite, SAID_LEAST)
    beside[: len(way) // 2] = True
    parting = np.where(beside, said, SAID_LEAST)
    return max(
        _best_way(chance, steps, OTHER_START_WIDTHS * width_px / unit_px)[1],
        _best_way(parting, steps, START_BLOCKS * steps)[1],
    )


def _said(strength: FloatArray, spread: float) -> FloatArray:
    """Return (blocks, shifts) the log odds that the strip is there."""
    strip = max(COURSE_STRIP_SPREAD, spread)
    odds = math.log(spread / strip) - 0.5 * ((np.minimum(strength, 1.0) - 1) / strip) ** 2
    odds += 0.5 * (np.maximum(strength, 0.0) / spread) ** 2
    # where all is sure, the middle of what shows it is
    return np.asarray(np.clip(odds, SAID_LEAST, SAID_MOST) + MIDDLE_SAID * np.clip(strength, 0, 1))


def _beside(
    way: FloatArray, shape: tuple[int, ...], steps_a_block: float, apart: float
) -> BoolArray:
    """Return (blocks, shifts) what lies beside a way, where the strip's flanks do not show."""
    at = np.full(shape[0], np.nan)
    at[: len(way)] = shape[1] // 2 + np.cumsum(way * steps_a_block)
    away = np.abs(np.arange(shape[1]) - at[:, None])
    return np.asarray(~(away <= apart))


def _best_way(said: FloatArray, steps_a_block: float, start: float) -> tuple[FloatArray, float]:
    """Return (blocks,) the slopes of the way that shows most, and what it shows.

    It begins within `start` steps of the middle and ends where it shows most.
    """
    blocks, shifts = said.shape
    kinds = len(SLOPES)
    moves = np.round(SLOPES * steps_a_block).astype(int)
    total = np.full((kinds, shifts), -np.inf)
    near = np.abs(np.arange(shifts) - shifts // 2) <= start
    total[:, near] = 0.0
    came = np.zeros((blocks, kinds, shifts), dtype=np.int8)
    best, end = 0.0, (-1, 0, 0)
    for b in range(blocks):
        moved = np.full((3, kinds, shifts), -np.inf)
        for q, turn in enumerate((-1, 0, 1)):
            for kind in range(max(0, -turn), min(kinds, kinds - turn)):
                # it came with another slope, and goes on with this one
                cost = BEND_COST * abs(turn)
                moved[q, kind] = _shifted(total[kind + turn], moves[kind]) - cost
        came[b] = moved.argmax(axis=0)
        total = moved.max(axis=0) + said[b]
        if total.max() > best:
            best, end = float(total.max()), (b, *divmod(int(total.argmax()), shifts))
    last, kind, shift = end
    slopes = np.empty(last + 1)
    for each in range(last, -1, -1):
        slopes[each] = moves[kind] / steps_a_block
        turn = int(came[each, kind, shift]) - 1
        shift -= moves[kind]
        kind += turn
    return slopes, best


def _shifted(values: FloatArray, by: int) -> FloatArray:
    out = np.full(len(values), -np.inf)
    if by >= 0:
        out[by:] = values[: len(values) - by]
    else:
        out[:by] = values[-by:]
    return out
