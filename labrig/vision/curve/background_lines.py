"""Straight lines of the background, such as wires: where each lies relative to a curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.thresholds import (
    CROSSING_LENGTH_MAX_REACHES,
    LINE_DIRECTION_MAX_RAD,
    LINE_END_SIGMA_PX,
    LINE_MATCH_MAX_PX,
)

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
MaskArray = npt.NDArray[np.uint8]

DIRECTION_NODES = 12  # nodes that show a curve's direction


@dataclass(frozen=True, eq=False)
class BackgroundLine:
    """A line in raw pixels from where it comes in to where it is last seen."""

    path: FloatArray  # (n, 2)
    seen: BoolArray  # (n,)
    half_px: float  # further beside it nothing of it is seen

    def runs_with(self, curve: FloatArray, reach: float) -> bool:
        """Return whether it lies on a curve (n, 2) for longer than a crossing takes.

        A crossing is a gap in the curve; what runs with it pulls it aside.
        """
        return (
            self._length_px(self._gaps(curve) < self.half_px + reach)
            > CROSSING_LENGTH_MAX_REACHES * reach
        )

    def length_beside_px(self, curve: FloatArray, reach: float) -> float:
        """Return of what is seen of it further than `reach` from a curve (n, 2)."""
        return self._length_px((self._gaps(curve) > reach) & self.seen)

    def _length_px(self, part: BoolArray) -> float:
        steps = np.hypot(*np.diff(self.path, axis=0).T)
        return float(steps[part[1:]].sum())

    def begins_at(self, clamp: FloatArray, least_px: float) -> bool:
        """Return whether it passes the clamp (2,) and hardly continues behind it, as a sheet."""
        gap = np.hypot(*(self.path - clamp).T)
        at = int(gap.argmin())
        behind = [np.hypot(*(self.path[end] - self.path[at])) for end in (0, -1)]
        return bool(gap[at] < LINE_MATCH_MAX_PX + self.half_px and min(behind) < least_px)

    def is_all_of(self, curve: FloatArray, reach: float) -> bool:
        """Return whether a whole curve (n, 2) lies on it, and both end together.

        As a straight sheet does.

        Behind the clamp it may continue, as the joint between two jaws does.
        """
        ends = self.path[[0, -1]] - curve[-1]
        gap = curve[::4, None] - self.path[None]
        beside = np.hypot(gap[..., 0], gap[..., 1]).min(axis=1)
        return bool(
            np.hypot(ends[:, 0], ends[:, 1]).min() < LINE_END_SIGMA_PX and beside.max() < reach
        )

    def ends_with(self, curve: FloatArray) -> bool:
        """Return whether it is seen up to the end of a curve (n, 2), and not straight on beyond.

        That is what the last part of the sheet looks like where it is straight.
        """
        ahead = curve[-1] - curve[-1 - DIRECTION_NODES]
        ahead /= np.hypot(*ahead)
        away = self.path[self.seen] - curve[-1]
        along, beside = away @ ahead, np.abs(away @ [-ahead[1], ahead[0]])
        straight_on = (
            beside
            < LINE_MATCH_MAX_PX + self.half_px + LINE_DIRECTION_MAX_RAD * np.maximum(along, 0.0)
        )
        reaches = np.hypot(away[:, 0], away[:, 1]).min() < LINE_END_SIGMA_PX
        return bool(reaches and along[straight_on].max(initial=0.0) < LINE_END_SIGMA_PX)

    def shows_at(self, place: FloatArray) -> bool:
        """Return whether it is seen at a place (2,)."""
        return bool(np.hypot(*(self.path - place).T).min() < LINE_MATCH_MAX_PX + self.half_px)

    def _gaps(self, curve: FloatArray) -> FloatArray:
        gap = self.path[:, None] - curve[None]
        return np.asarray(np.hypot(gap[..., 0], gap[..., 1]).min(axis=1))


def hidden_by(wires: Sequence[BackgroundLine], shape: tuple[int, int]) -> MaskArray:
    """Return (rows, columns): not 0 where a wire is seen."""
    import cv2

    mask = np.zeros(shape, np.uint8)
    for wire in wires:
        points = np.round(wire.path * 16).astype(np.int32).reshape(-1, 1, 2)
        width = max(1, round(2 * wire.half_px))
        cv2.polylines(
            mask, [points], isClosed=False, color=1, thickness=width, lineType=cv2.LINE_8, shift=4
        )
    return mask
