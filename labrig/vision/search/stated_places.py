"""Locate a strip through places on it that somebody has stated: no search for where it may be.

Between two places the path is the one along which the image looks most like a strip of some
width. Of several widths, and both polarities, the clearest pair of edges is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from labrig.vision.image.image import GreyImage
from labrig.vision.search.edge_width import measured_along
from labrig.vision.search.locate import widths_tried
from labrig.vision.search.located import Located
from labrig.vision.search.ridge_tracing import RidgeMaps, ridge_maps
from labrig.vision.search.straightened import resampled, smoothed

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]
MaskArray = npt.NDArray[np.uint8]
Point = tuple[float, float]

RIDGE_HALF = 5.0  # strength of a ridge, in noise, that counts half
SLOPE_SHARE = 0.7  # of a slope that makes a ridge an edge
COST_MIN = 0.04  # of a pixel on the clearest ridge; off any ridge it is 1 more
CLICK_PX, CLICK_WIDTHS = 3.0, 0.5  # how far beside the middle a place may be stated
ROOM_SHARE = 0.6  # of two places' distance: how far beside both the path may go


def locate_through(
    image: GreyImage,
    places_px: Sequence[Point],
    *,
    mask: MaskArray | None = None,
    signs: tuple[float, ...],
    thickness_px: float | None,
) -> Located | None:
    """Return the clearest strip through places (raw pixels, the clamp first); None: none is seen.

    The path is the whole one up to the last place. `mask`, `signs`: as in `locate.locate`.
    """
    best: tuple[float, Located] | None = None
    longest = min(_chord_px(places_px), max(image.grey.shape))
    filled = image.filled()
    for width in widths_tried(image, thickness_px, longest):
        ridges = ridge_maps(filled, width, wide=False)
        if mask is not None and mask.any():
            ridges.hide(mask)
        for sign in signs:
            path = _path(ridges, sign, places_px, width)
            clamp = places_px[0]
            found = measured_along(image, path, width, sign, fixed=thickness_px, clamp=clamp)
            if found is not None and (best is None or found.worth > best[0]):
                # the strip goes on to the last place, however faint it is before
                step = max(1.0, 0.25 * width)
                whole = smoothed(resampled(path, step), round(2 * width / step))
                whole = _beginning_at(whole, np.array(clamp), width)
                best = found.worth, replace(found, path_px=whole, leaves_image=False)
    return None if best is None else best[1]


def _beginning_at(path: FloatArray, clamp: FloatArray, width: float) -> FloatArray:
    """Return a path that begins beside the clamp: the clearest place near it may lie along it."""
    few = max(1, int(np.searchsorted(np.hypot(*(path - path[0]).T), width)))
    ahead = path[min(few, len(path) - 1)] - path[0]
    ahead = ahead / max(float(np.hypot(*ahead)), 1e-9)
    along = (path - clamp) @ ahead
    if along[0] > 0:  # the path begins after the clamp
        return np.concatenate([[path[0] - along[0] * ahead], path])
    first = int(np.argmax(along > 0))
    return path[first:]


def _chord_px(places_px: Sequence[Point]) -> float:
    return float(np.hypot(*np.diff(np.array(places_px), axis=0).T).sum())


def _path(ridges: RidgeMaps, sign: float, places_px: Sequence[Point], width: float) -> FloatArray:
    """Return the path (raw pixels) from each place to the next."""
    cost = _cost(ridges, sign)
    reach = max(CLICK_PX, CLICK_WIDTHS * width) / ridges.scale
    inner = [(np.array(place) + 0.5) / ridges.scale - 0.5 for place in places_px]
    nodes = [_clearest(cost, place, reach) for place in inner]
    pieces = [_between(cost, a, b) for a, b in pairwise(nodes)]
    path = np.concatenate([pieces[0][:1], *(piece[1:] for piece in pieces)]).astype(np.float64)
    return ridges.raw(path)


def _cost(ridges: RidgeMaps, sign: float) -> MapArray:
    """Return (rows, columns) what a step through each pixel costs, in whichever direction."""
    uu, uv, vv, slope_u, slope_v = ridges.maps[0]
    across = np.sqrt((0.5 * (uu - vv)) ** 2 + uv**2) - sign * 0.5 * (uu + vv)
    strength = np.maximum(across - SLOPE_SHARE * np.hypot(slope_u, slope_v), 0.0)
    gain = strength / (strength + RIDGE_HALF)
    return np.asarray(1.0 + COST_MIN - gain, dtype=np.float32)


def _clearest(cost: MapArray, place: FloatArray, reach: float) -> tuple[int, int]:
    """Return column and row of the cheapest pixel near a place; of equal ones the nearest."""
    rows, columns = cost.shape
    u, v = np.clip(place, 0, [columns - 1, rows - 1])
    many = math.ceil(reach)
    i0, j0 = max(0, round(v) - many), max(0, round(u) - many)
    part = cost[i0 : round(v) + many + 1, j0 : round(u) + many + 1]
    i, j = np.indices(part.shape)
    apart = np.hypot(i + i0 - v, j + j0 - u) / max(reach, 1.0)
    wanted = np.where(apart <= 1.0, part + 0.3 * apart**2, np.inf)
    if not np.isfinite(wanted).any():
        return round(float(u)), round(float(v))
    at = np.unravel_index(int(wanted.argmin()), part.shape)
    return int(at[1]) + j0, int(at[0]) + i0


def _between(cost: MapArray, first: tuple[int, int], last: tuple[int, int]) -> FloatArray:
    """Return the cheapest path (n, 2) of columns and rows between two pixels."""
    from labrig.vision.search.shortest_path import shortest_path

    if first == last:
        return np.array([first], dtype=np.float64)
    room = math.ceil(ROOM_SHARE * math.dist(first, last)) + 4
    j0, i0 = (max(0, min(a, b) - room) for a, b in zip(first, last, strict=True))
    j1, i1 = (max(a, b) + room + 1 for a, b in zip(first, last, strict=True))
    part = np.ascontiguousarray(cost[i0:i1, j0:j1])
    columns = part.shape[1]
    ends = [(v - i0) * columns + (u - j0) for u, v in (first, last)]
    found = shortest_path(part, ends[0], ends[1])
    return np.stack([found % columns + j0, found // columns + i0], axis=1).astype(np.float64)
