"""The clamp, and places on a strip that somebody has stated, as measurements of its curve.

Where an edge is hidden they say where the strip is; edges that contradict a place on the strip are
another thing's. A clamp may be stated roughly, and then says nothing of the place across.
The own edges of a clamp and of a tip pull all middles beside them alike, the less the further
away; where the end is stated, the likeliest pull follows from how far it lies beside the middles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.thresholds import OUTLINE_END_SIGMA_MAX_PX, OUTLINE_END_SIGMA_RATIO

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

CLAMP_SIGMAS_MAX = 3.0  # beside the curve: so far a stated clamp is used
CLAMP_SHARE = 1 / 8  # of the length, in which the clamp lies
PLACE_SIGMA_PX = 1.5  # of a place that is stated, across the strip
PLACE_SIGMA_WIDTHS = 0.05  # or so much of a thick one, whichever is more
NEAR_WIDTHS, NEAR_MIN_PX = 1.0, 6.0  # along the strip: what must agree with a place
APART_WIDTHS, APART_MIN_PX = 0.35, 4.0  # across it: what contradicts one


@dataclass(frozen=True, eq=False, kw_only=True)
class StatedPlaces:
    """Places in the sheet's plane and their standard deviations across the strip, in pixels."""

    clamp_px: FloatArray  # (2,)
    clamp_sigma_px: float
    on_strip_px: FloatArray  # (places, 2)
    sigma_px: float  # of each of these
    tip_stated: bool = False  # the last of these is the end
    tip_seen_px: FloatArray | None = None  # (2,) the middle of a tip that is not stated
    tip_seen_sigma_px: float = 0.0

    @classmethod
    def of(cls, optics: Optics, width_px: float) -> StatedPlaces:
        """Return what `optics` states of a strip so thick."""
        on_strip = np.array(optics.stated_places_px, dtype=float).reshape(-1, 2)
        return cls(
            clamp_px=optics.clamp_m() * optics.px_per_m,
            clamp_sigma_px=optics.clamp_sigma_px,
            on_strip_px=optics.pixel_to_world(on_strip) * optics.px_per_m,
            sigma_px=max(PLACE_SIGMA_PX, PLACE_SIGMA_WIDTHS * width_px),
            tip_stated=optics.tip_px is not None,
        )

    def __bool__(self) -> bool:
        """Whether there is a place beside the clamp."""
        return len(self.on_strip_px) > 0

    def nodes(self, shape: CurveShape) -> IntArray:
        """Return (places,) a curve's nodes nearest to the places on the strip."""
        return _nearest(shape, self.on_strip_px, len(shape.x))

    def information(self, shape: CurveShape) -> tuple[FloatArray, FloatArray]:
        """Return what all places add to the normal matrix and the right-hand side of a fit."""
        known = self.clamp_offset_px(shape) is not None
        node = [self._clamp_node(shape), self.nodes(shape)]
        at = [self.clamp_px[None], self.on_strip_px]
        weight = [
            np.array([known / self.clamp_sigma_px]),
            np.full(len(self.on_strip_px), 1 / self.sigma_px),
        ]
        if self.tip_seen_px is not None:
            node.append(_last_node(shape))
            at.append(self.tip_seen_px[None])
            weight.append(np.array([1 / self.tip_seen_sigma_px]))
        return _information(shape, np.concatenate(node), np.concatenate(at), np.concatenate(weight))

    def clamp_offset_px(self, shape: CurveShape) -> float | None:
        """Return how far to the left of a curve the clamp lies; None where it says nothing."""
        offset = float(_offset(shape, self._clamp_node(shape), self.clamp_px[None])[0])
        return offset if abs(offset) < CLAMP_SIGMAS_MAX * self.clamp_sigma_px else None

    def tip_offset_px(self, shape: CurveShape) -> float | None:
        """Return how far to the left of a curve's end the tip lies; None where it is not known."""
        tip = self.on_strip_px[-1] if self.tip_stated else self.tip_seen_px
        return None if tip is None else float(_offset(shape, _last_node(shape), tip[None])[0])

    @property
    def tip_sigma_px(self) -> float:
        """Standard deviation of the tip, across the strip."""
        return self.sigma_px if self.tip_stated else self.tip_seen_sigma_px

    def apart_px(self, shape: CurveShape) -> float:
        """Return the RMS distance of the places from a curve, less what they are known to."""
        if not self:
            return 0.0
        square = float(np.mean(_offset(shape, self.nodes(shape), self.on_strip_px) ** 2))
        return math.sqrt(max(square - self.sigma_px**2, 0.0))

    def _clamp_node(self, shape: CurveShape) -> IntArray:
        return _nearest(shape, self.clamp_px[None], max(1, round(CLAMP_SHARE * len(shape.x))))

    def contradicted(
        self, shape: CurveShape, node: IntArray, middle_px: FloatArray, width_px: float
    ) -> BoolArray:
        """Return (nodes,) which middles, to the left of a curve, lie elsewhere than a place."""
        found = np.zeros(len(node), dtype=bool)
        s, places = shape.basis.s, self.nodes(shape)
        near = max(NEAR_WIDTHS * width_px, NEAR_MIN_PX)
        most = max(APART_WIDTHS * width_px, APART_MIN_PX)
        for at, offset in zip(places, _offset(shape, places, self.on_strip_px), strict=True):
            beside = np.abs(s[node] - s[at]) < near
            found |= beside & (np.abs(middle_px - offset) > most)
        return found


def _information(
    shape: CurveShape, node: IntArray, places_px: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray]:
    modes = shape.normal_modes()[node] * weight[:, None]
    normal = modes.T @ modes
    offset = _offset(shape, node, places_px)
    return normal, modes.T @ (weight * offset) + normal @ shape.parameters


def _last_node(shape: CurveShape) -> IntArray:
    return np.array([len(shape.x) - 1])


def _nearest(shape: CurveShape, places_px: FloatArray, among: int) -> IntArray:
    x, y = places_px.T[:, :, None]
    apart = np.hypot(shape.x[None, :among] - x, shape.y[None, :among] - y)
    return np.asarray(apart.argmin(axis=1), dtype=np.int64)


def _offset(shape: CurveShape, node: IntArray, places_px: FloatArray) -> FloatArray:
    """Return how far to the left of a curve's nodes the places lie."""
    x, y = places_px.T
    sin, cos = np.sin(shape.phi[node]), np.cos(shape.phi[node])
    return np.asarray(cos * (y - shape.y[node]) - sin * (x - shape.x[node]))


def end_pull_px(away_px: FloatArray, width_px: float) -> FloatArray:
    """Return one standard deviation of the pull, so far away from an end."""
    most = min(OUTLINE_END_SIGMA_RATIO * width_px, OUTLINE_END_SIGMA_MAX_PX)
    return np.asarray(most * np.exp(-away_px / width_px))


def likeliest_pull_px(
    away_px: FloatArray,
    middle_px: FloatArray,
    near: BoolArray,
    *,
    width_px: float,
    end_offset_px: float,
    end_sigma_px: float,
    sigmas_max: float,
) -> FloatArray:
    """Return (blocks,) what is to be taken from the middles, which lie so far to the left.

    `near`: the blocks whose middles are compared with the end's place, `end_offset_px` to the
    left of the curve. Further from it than `sigmas_max` they are another thing's, and nothing
    is taken.
    """
    pull = end_pull_px(away_px, width_px)
    if not near.any():
        return np.zeros(len(pull))
    here = float(np.median(pull[near]))
    apart = float(np.median(middle_px[near])) - end_offset_px
    if abs(apart) > sigmas_max * np.hypot(here, end_sigma_px):
        return np.zeros(len(pull))
    return np.asarray(apart * pull * here / (here**2 + end_sigma_px**2))
