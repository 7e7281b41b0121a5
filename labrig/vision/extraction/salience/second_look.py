"""A second look at a strip of which little is stated: by what stands out in the picture.

Edges and profiles show a strip to parts of a pixel, but may end at a ring, a change of colour or a
bend. What stands out is coarse, but whole. It counts where two looks agree: at the picture and at
the part of it where the strip lies, or at the picture turned over. It does not where the strip
stands out in pieces: it is hidden between them, and where one ends the strip does not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extraction.salience.merging import CUT, LED_ON, halfway, merged
from labrig.vision.extraction.salience.middle_line import (
    LEVEL,
    MapArray,
    MiddleLine,
    distances,
    lengths,
    middle_line,
    sampled,
)
from labrig.vision.extraction.salience.network import SIDE_PX, salience

FloatArray = npt.NDArray[np.float64]
ImageArray = npt.NDArray[Any]

# Of the network's pixels. Of 129 curves of photographs those of thinner strips were changed five
# times, never for the better or the worse; those that were put right had 11 at least.
WIDTH_MIN_PIXELS = 8.0
SLENDER_MIN = 5.0  # length over width, also of a piece beyond a place where the strip is hidden
WIDTH_SCATTER_MAX = 0.25
SURELY_MIN = 0.8
ROOM_SHARE, ROOM_MIN_PX = 0.15, 10.0  # around a strip, that the nearer look shows
NEARER_MAX = 0.8  # of the picture's side: else it is the same look
AGREE_WIDTHS, AGREE_PIXELS = 0.25, 1.0  # between two looks, in the mean
AGREE_END_SHARE, AGREE_END_PIXELS = 0.03, 2.0
BORDER_PIXELS = 2.0  # of the map, from the image's border: the strip leaves it
LEAVES_PX = 10.0  # from there a curve's end: the same


def seen_again(
    first: NeutralCurve, image: ImageArray, optics: Optics, strip: StripGeometry
) -> NeutralCurve:
    """Return a curve after a second look at the picture.

    It stays as it is where it was refused, where length, tip or what confuses is stated, where the
    strip leaves the image, and where it is too thin for the network.
    """
    if not first.ok or strip.length_known or optics.stated_places_px or optics.mask_px:
        return first
    path, part = first.points_px, _around(first.points_px, image)
    px_per_m = float(lengths(path)[-1] / first.s_m[-1])
    thin = first.thickness_m * px_per_m < WIDTH_MIN_PIXELS * part.pixel_px
    if thin or _leaves(path, image, LEAVES_PX):
        return first
    look = stands_out(image, np.array(optics.clamp_px), _turned_to(path), path_px=path)
    return first if look is None else merged(first, look, optics)


def changed_by_it(curve: NeutralCurve) -> bool:
    """Return whether a second look led a curve on or cut it."""
    return any(text in {LED_ON, CUT} for text in curve.warnings)


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
        self, image: ImageArray, clamp_px: FloatArray, heading_rad: float, path_px: FloatArray
    ) -> MiddleLine | None:
        """Return the strip that stands out in it, in pixels of the image.

        None where only a piece does: the strip's path, as it was found otherwise, leads to another.
        """
        (u, v), (columns, rows) = self.first, self.size
        part = np.ascontiguousarray(image[v : v + rows, u : u + columns][:, :: self._step])
        shown = np.ascontiguousarray(salience(part)[:, :: self._step])
        clamp = np.asarray(clamp_px, dtype=float) - self.first
        found = middle_line(shown, clamp, heading_rad, self.pixel_px)
        if found is None or _stands_out_again(shown, path_px - self.first, found):
            return None
        return replace(found, path_px=found.path_px + self.first)

    @property
    def pixel_px(self) -> float:
        """Width of a pixel of what the network is shown."""
        return max(self.size) / SIDE_PX

    @property
    def _step(self) -> int:
        return -1 if self.turned else 1


def stands_out(
    image: ImageArray,
    clamp_px: FloatArray,
    heading_rad: float,
    *,
    path_px: FloatArray,
) -> MiddleLine | None:
    """Return the strip that stands out beside the clamp; None where it does not do so surely.

    `path_px`: of the strip as it was found otherwise. It tells where to look if the picture as a
    whole shows nothing, and whether the strip stands out beyond a place where it is hidden.
    """
    whole = _PicturePart(first=(0, 0), size=(image.shape[1], image.shape[0]))
    once = _strip(whole.look(image, clamp_px, heading_rad, path_px))
    nearer = _around(path_px if once is None else once.path_px, image)
    near = max(nearer.size) < NEARER_MAX * max(whole.size)
    if once is None:
        whole = nearer  # what is small in a picture stands out in a part of it
        once = _strip(whole.look(image, clamp_px, heading_rad, path_px)) if near else None
        near = False
    if once is None:
        return None
    for part in (nearer, replace(whole, turned=True))[not near :]:
        again = _strip(part.look(image, clamp_px, heading_rad, path_px))
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


def _stands_out_again(shown: MapArray, path_px: FloatArray, found: MiddleLine) -> bool:
    """Return whether a path leads on from where a strip ceases to stand out to where one does.

    What is not slender may be another thing beyond the tip.
    """
    nearest = int(np.hypot(*(path_px - found.path_px[-1]).T).argmin())
    beyond = path_px[nearest:]
    out = sampled(shown, beyond) > LEVEL
    again = out & ~np.logical_and.accumulate(out)
    return float(np.diff(lengths(beyond))[again[1:]].sum()) > SLENDER_MIN * found.width_px


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
