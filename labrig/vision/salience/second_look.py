"""A second look at a strip of which little is stated: by what stands out in the picture.

Edges and profiles show a strip to parts of a pixel, but may end at a ring, a change of colour or a
bend. What stands out is coarse, but whole. It counts where two looks agree: at the picture and at
the part of it where the strip lies, or at the picture turned over.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.salience.merging import alone, halfway, merged
from labrig.vision.salience.middle_line import MiddleLine, distances, lengths, middle_line
from labrig.vision.salience.network import SIDE_PX, missing, salience, weights_file

FloatArray = npt.NDArray[np.float64]
ImageArray = npt.NDArray[Any]

SLENDER_MIN = 5.0  # length over width
WIDTH_SCATTER_MAX = 0.25
SURELY_MIN = 0.8
ROOM_SHARE, ROOM_MIN_PX = 0.15, 10.0  # around a strip, that the nearer look shows
NEARER_MAX = 0.8  # of the picture's side: else it is the same look
AGREE_WIDTHS, AGREE_PIXELS = 0.25, 1.0  # between two looks, in the mean
AGREE_END_SHARE, AGREE_END_PIXELS = 0.03, 2.0
BORDER_PIXELS = 2.0  # of the map, from the image's border: the strip leaves it
LEAVES_PX = 10.0  # from there a curve's end: the same
HEADING_PX = 10.0
NO_PICTURE = "check of the image"  # a refusal of a picture that cannot hold a curve


def seen_again(
    first: NeutralCurve, image: ImageArray, optics: Optics, strip: StripGeometry
) -> NeutralCurve:
    """Return a curve, or the reason why there is none, after a second look at the picture.

    It stays as it is where length, tip or what confuses is stated, where its direction at the
    clamp is neither stated nor found, and where the strip leaves the image.
    """
    if strip.length_known or optics.stated_places_px or optics.mask_px or image.ndim < 2:
        return first
    path = first.points_px if first.ok else None
    if path is not None and _leaves(path, image, LEAVES_PX):
        return first
    heading = _heading_rad(optics) if path is None else _turned_to(path)
    if heading is None or first.why.startswith(NO_PICTURE):
        return first
    weights = weights_file()
    if weights is None:
        return NeutralCurve(ok=False, why=missing())
    clamp = np.array(optics.clamp_px)
    look = stands_out(image, clamp, heading, weights, path_px=path)
    if look is None:
        return first
    return merged(first, look, optics) if first.ok else alone(first, look, optics)


def _heading_rad(optics: Optics) -> float | None:
    """Return the stated direction of the strip in the image; None where it is not stated."""
    if not optics.clamp_angle_known:
        return None
    start, angle = optics.clamp_m(), optics.clamp_angle_rad
    step = HEADING_PX / optics.px_per_m * np.array([math.cos(angle), math.sin(angle)])
    (u0, v0), (u1, v1) = optics.world_to_pixel([start, start + step])
    return math.atan2(v1 - v0, u1 - u0)


def _turned_to(path_px: FloatArray) -> float:
    u, v = path_px[max(1, len(path_px) // 12)] - path_px[0]
    return math.atan2(v, u)


@dataclass(frozen=True, eq=False, kw_only=True)
class _PicturePart:
    """A part of a picture that is looked at, perhaps turned over."""

    first: tuple[int, int]  # its first pixel, column and row
    size: tuple[int, int]  # columns, rows
    turned: bool = False

    def look(
        self, image: ImageArray, clamp_px: FloatArray, heading_rad: float, weights: Path
    ) -> MiddleLine | None:
        """Return the strip that stands out in it, in pixels of the image."""
        (u, v), (columns, rows) = self.first, self.size
        part = np.ascontiguousarray(image[v : v + rows, u : u + columns][:, :: self._step])
        shown = np.ascontiguousarray(salience(part, weights)[:, :: self._step])
        clamp = np.asarray(clamp_px, dtype=float) - self.first
        found = middle_line(shown, clamp, heading_rad, max(self.size) / SIDE_PX)
        return None if found is None else replace(found, path_px=found.path_px + self.first)

    @property
    def _step(self) -> int:
        return -1 if self.turned else 1


def stands_out(
    image: ImageArray,
    clamp_px: FloatArray,
    heading_rad: float,
    weights: Path,
    *,
    path_px: FloatArray | None,
) -> MiddleLine | None:
    """Return the strip that stands out beside the clamp; None where it does not do so surely.

    `path_px`: of the strip as it was found otherwise, where the picture as a whole shows nothing.
    """
    whole = _PicturePart(first=(0, 0), size=(image.shape[1], image.shape[0]))
    once = _strip(whole.look(image, clamp_px, heading_rad, weights))
    around = once.path_px if once is not None else path_px
    if around is None:
        return None
    nearer = _around(around, image)
    near = max(nearer.size) < NEARER_MAX * max(whole.size)
    if once is None:
        whole = nearer  # what is small in a picture stands out in a part of it
        once = _strip(whole.look(image, clamp_px, heading_rad, weights)) if near else None
        near = False
    if once is None:
        return None
    for part in (nearer, replace(whole, turned=True))[not near :]:
        again = _strip(part.look(image, clamp_px, heading_rad, weights))
        if again is not None and _agree(once, again):
            if _leaves(again.path_px, image, BORDER_PIXELS * again.pixel_px):
                return None
            return replace(again, path_px=halfway(again.path_px, once.path_px))
    return None


def _strip(found: MiddleLine | None) -> MiddleLine | None:
    """Return what may be a strip by its shape, and surely stands out."""
    if found is None or found.surely < SURELY_MIN or found.width_scatter > WIDTH_SCATTER_MAX:
        return None
    return found if found.length_px > SLENDER_MIN * found.width_px else None


def _around(path_px: FloatArray, image: ImageArray) -> _PicturePart:
    room = ROOM_SHARE * float(lengths(path_px)[-1]) + ROOM_MIN_PX
    first = np.maximum(np.floor(path_px.min(axis=0) - room), 0).astype(int)
    last = np.minimum(np.ceil(path_px.max(axis=0) + room), image.shape[1::-1]).astype(int)
    columns, rows = last - first
    return _PicturePart(first=(int(first[0]), int(first[1])), size=(int(columns), int(rows)))


def _agree(one: MiddleLine, other: MiddleLine) -> bool:
    """Return whether two looks show the same strip up to the same end."""
    pixel, length = max(one.pixel_px, other.pixel_px), other.length_px
    aside = float(np.mean(distances(one.path_px, other.path_px)))
    end = max(AGREE_END_SHARE * length, AGREE_END_PIXELS * pixel)
    tips = float(np.hypot(*(one.path_px[-1] - other.path_px[-1])))
    return aside < AGREE_WIDTHS * other.width_px + AGREE_PIXELS * pixel and tips < end


def _leaves(path_px: FloatArray, image: ImageArray, room_px: float) -> bool:
    """Return whether a path ends at the image's border."""
    tip, last = path_px[-1], np.array(image.shape[1::-1]) - 1
    return bool(min(tip.min(), (last - tip).min()) < room_px)
