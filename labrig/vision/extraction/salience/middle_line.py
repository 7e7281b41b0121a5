"""The middle line of a strip in a map of what stands out: from the clamp to the farthest place.

The map is sure and smooth, but coarse: the line is as good as a part of one of its pixels, and
shows where a strip leads and ends, whatever is drawn on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
MapArray = npt.NDArray[np.float32]

LONG_SIDE_PX = 480  # of the map, as it is looked at
LEVEL = 0.5  # of the map, at a strip's edge
CLAMP_REACH_PX = 20.0  # in the image: how far from the clamp a strip may begin
BEHIND_PX, BEHIND_WIDTHS, BEHIND_ASIDE_WIDTHS = 4.0, 0.5, 3.0  # the clamp is cut off there
PIXELS_MIN = 30  # of a strip
DEEP = 0.3  # of the largest depth, added to it: how much a path keeps to the middle
ROUNDS = 3  # of putting the path midway between both edges
CROSS_STEP_PX = 0.25
STIFFNESS = 5e-4  # of a path, over widths to the fourth
ENDS_WIDTHS = 0.4  # at the clamp the edges across are not the strip's sides
BLUNT_SHARE = 0.8  # of the width, that an end has which does not taper, one width before it
CORNER_WIDTHS, CORNER_DEPTHS = 0.6, 1.2  # before an end a path leads into one of its corners
UNUSUAL_WIDTH = 1.5  # to the usual one: another thing touches it there
ENDS_FROM_WIDTHS = 0.6  # of the path, that show its direction at an end


@dataclass(frozen=True, eq=False, kw_only=True)
class MiddleLine:
    """A strip as it stands out, in pixels of the image."""

    path_px: FloatArray  # (n, 2), from the clamp to the tip
    width_px: float  # the usual one
    wide_px: FloatArray  # (n,) along the path; NaN where no edges show
    width_scatter: float  # of its width about an even taper, as a share
    surely: float  # the share of its length that surely stands out
    pixel_px: float  # one of the map's pixels

    @property
    def length_px(self) -> float:
        """Length of the path."""
        return float(lengths(self.path_px)[-1])


def middle_line(
    salience: MapArray, clamp_px: FloatArray, heading_rad: float, pixel_px: float
) -> MiddleLine | None:
    """Return the strip that leads away from the clamp; None where none stands out there."""
    import cv2

    scale = min(1.0, LONG_SIDE_PX / max(salience.shape))
    if scale < 1:
        size = [max(1, round(side * scale)) for side in salience.shape[::-1]]
        salience = np.asarray(cv2.resize(salience, size, interpolation=cv2.INTER_AREA))
    clamp = (np.asarray(clamp_px, dtype=float) + 0.5) * scale - 0.5
    strip = _beyond_clamp(salience > LEVEL, clamp, heading_rad, CLAMP_REACH_PX * scale)
    if strip is None:
        return None
    found = _line(salience, clamp, *strip)
    if found is None:
        return None
    return replace(
        found,
        path_px=(found.path_px + 0.5) / scale - 0.5,
        width_px=found.width_px / scale,
        wide_px=found.wide_px / scale,
        pixel_px=pixel_px,
    )


def _beyond_clamp(
    stands_out: BoolArray, clamp: FloatArray, heading_rad: float, reach: float
) -> tuple[BoolArray, tuple[int, int]] | None:
    """Return the part that leads away from the clamp, and where it begins (column, row)."""
    depth = _depth(stands_out)
    u, v = np.clip(np.round(clamp).astype(int), 2, np.array(stands_out.shape[::-1]) - 3)
    width = 2 * max(1.0, float(depth[v - 2 : v + 3, u - 2 : u + 3].max(initial=0.0)))
    rows, columns = np.mgrid[: stands_out.shape[0], : stands_out.shape[1]]
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    along = (columns - clamp[0]) * cos + (rows - clamp[1]) * sin
    aside = np.abs((rows - clamp[1]) * cos - (columns - clamp[0]) * sin)
    behind = (along < -1) & (along > -BEHIND_PX - BEHIND_WIDTHS * width)
    left = stands_out & ~(behind & (aside < BEHIND_ASIDE_WIDTHS * width + 2 * BEHIND_PX))
    v_all, u_all = np.nonzero(left & (along > -1.5))
    if not len(u_all):
        return None
    apart = np.hypot(u_all - clamp[0], v_all - clamp[1])
    nearest = int(apart.argmin())
    if apart[nearest] > reach + BEHIND_WIDTHS * width:
        return None
    begin = int(u_all[nearest]), int(v_all[nearest])
    import cv2

    parts = cv2.connectedComponents(left.astype(np.uint8))[1]
    strip = np.asarray(parts == parts[begin[1], begin[0]])
    return (strip, begin) if strip.sum() >= PIXELS_MIN else None


def _depth(strip: BoolArray) -> MapArray:
    import cv2

    # the image's border is no edge of what leaves it
    wide = cv2.copyMakeBorder(strip.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    return np.asarray(cv2.distanceTransform(wide, cv2.DIST_L2, 5))[1:-1, 1:-1]


def _line(
    salience: MapArray, clamp: FloatArray, strip: BoolArray, begin: tuple[int, int]
) -> MiddleLine | None:
    """Return the strip's middle line, in the map's pixels."""
    depth = _depth(strip)
    path = _way_to_farthest(strip, begin, 1 / (DEEP + depth / depth.max()) ** 2)
    inside = np.round(path).astype(int)
    width = 2 * float(np.median(depth[inside[:, 1], inside[:, 0]]))
    path = _smoothed(_without_corner(path, depth, width), width)
    for _ in range(ROUNDS):
        middle, wide = _across(salience, path, width)
        s = lengths(path)
        usual = float(np.nanmedian(wide)) if np.isfinite(wide).any() else width
        good = np.isfinite(middle) & (wide < UNUSUAL_WIDTH * usual)
        good &= s > ENDS_WIDTHS * width
        if good.sum() < 5:
            return None
        middle = np.interp(s, s[good], middle[good])
        first, last = (float(s[good][each] / s[-1]) for each in (0, -1))
        taper = np.polynomial.Polynomial.fit(s[good], wide[good], 1)(s[good])
        scatter, last_width = float(np.std(wide[good] - taper)), float(wide[good][-1])
        width = float(np.median(wide[good]))
        path = _smoothed(path + middle[:, None] * left_of(path), width)
    s = lengths(path) / lengths(path)[-1]
    path = _with_ends(salience, clamp, path[(s >= first) & (s <= last)], width, last_width)
    return MiddleLine(
        path_px=path,
        width_px=width,
        wide_px=_across(salience, path, width)[1],
        width_scatter=scatter / width,
        surely=float((sampled(salience, path) > 0.9).mean()),
        pixel_px=1.0,
    )


def _way_to_farthest(strip: BoolArray, begin: tuple[int, int], cost: FloatArray) -> FloatArray:
    """Return (n, 2) the cheapest way to the place to which all ways are longest."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    index = np.full(strip.shape, -1)
    v, u = np.nonzero(strip)
    index[v, u] = np.arange(len(u))
    ones, others, steps, costs = [], [], [], []
    padded = np.pad(index, 1, constant_values=-1)
    for dv, du in ((0, 1), (1, 0), (1, 1), (1, -1)):
        other = padded[v + 1 + dv, u + 1 + du]
        there = other >= 0
        one, other = np.flatnonzero(there), other[there]
        length = math.hypot(dv, du)
        ones.append(one)
        others.append(other)
        steps.append(np.full(len(one), length))
        costs.append(length * 0.5 * (cost[v[one], u[one]] + cost[v[other], u[other]]))
    pairs = (np.concatenate(ones), np.concatenate(others))
    size = (len(u), len(u))
    first = int(index[begin[1], begin[0]])
    plain = coo_array((np.concatenate(steps), pairs), shape=size).tocsr()
    away = dijkstra(plain, directed=False, indices=[first])[0]
    at = int(np.where(np.isfinite(away), away, -1).argmax())
    graph = coo_array((np.concatenate(costs), pairs), shape=size).tocsr()
    before = dijkstra(graph, directed=False, indices=[first], return_predecessors=True)[1][0]
    way = [at]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return np.asarray(np.stack([u[way], v[way]], axis=1)[::-1], dtype=float)


def _without_corner(path: FloatArray, depth: MapArray, width: float) -> FloatArray:
    """Return a path without its last part, which leads into a corner where the end is blunt."""
    s, inside = lengths(path), np.round(path).astype(int)
    before_end, deep = s[-1] - s, depth[inside[:, 1], inside[:, 0]]
    blunt = np.interp(width, before_end[::-1], deep[::-1]) > BLUNT_SHARE * width / 2
    corner = CORNER_WIDTHS * width if blunt else CORNER_DEPTHS * deep
    return path[: max(3, int((before_end < corner).argmax()))]


def _smoothed(path: FloatArray, width: float) -> FloatArray:
    """Return a path in steps of one pixel that bends no more than it must."""
    from scipy.linalg import solveh_banded

    s = lengths(path)
    many = max(6, round(s[-1]) + 1)
    even = np.linspace(0, s[-1], many)
    path = np.stack([np.interp(even, s, path[:, axis]) for axis in (0, 1)], axis=1)
    stiff = STIFFNESS * max(width, 3.0) ** 4
    second = np.diff(np.eye(3), 2, axis=0)[0]
    bands = np.zeros((3, many))
    bands[2] = 1.0
    for i, one in enumerate(second):
        for j in range(i, 3):
            bands[2 - (j - i), j : many - 2 + j] += stiff * one * second[j]
    return np.asarray(solveh_banded(bands, path))


def _across(salience: MapArray, path: FloatArray, width: float) -> tuple[FloatArray, FloatArray]:
    """Return (n,) how far to the left the middle between both edges lies, and the width; or NaN."""
    reach = math.ceil((1.2 * width + 3) / CROSS_STEP_PX)
    t = np.arange(-reach, reach + 1) * CROSS_STEP_PX
    shown = sampled(salience, path[:, None] + t[:, None] * left_of(path)[:, None])
    left, right = _falls(shown[:, reach:]), _falls(shown[:, reach::-1])
    return 0.5 * (left - right), left + right


def _falls(shown: FloatArray) -> FloatArray:
    """Return (n,) how far out a map first falls below the level; NaN where it does not."""
    below = shown < LEVEL
    at = below.argmax(axis=1)
    rows = np.arange(len(shown))
    inner, outer = shown[rows, at - 1], shown[rows, at]
    share = (inner - LEVEL) / np.maximum(inner - outer, 1e-9)
    return np.where((at > 0) & below.any(axis=1), (at - 1 + share) * CROSS_STEP_PX, np.nan)


def _with_ends(
    salience: MapArray, clamp: FloatArray, path: FloatArray, width: float, last_width: float
) -> FloatArray:
    """Return a path led on straight to the clamp, and to where the strip ends."""
    few, last_few = (
        min(max(2, round(ENDS_FROM_WIDTHS * each)), len(path) // 3) for each in (width, last_width)
    )
    back, ahead = path[0] - path[few], path[-1] - path[-1 - last_few]
    back, ahead = back / np.hypot(*back), ahead / np.hypot(*ahead)
    more = float((clamp - path[0]) @ back)
    start = path[0] + np.arange(math.floor(max(more, 0.0)), 0, -1.0)[:, None] * back
    beyond = path[-1] + np.arange(0, 2 * width + 10, CROSS_STEP_PX)[:, None] * ahead
    shown = sampled(salience, beyond) > LEVEL
    many = len(shown) if shown.all() else int(shown.argmin())
    step = round(1 / CROSS_STEP_PX)
    return np.concatenate([start, path, beyond[step:many:step]])


def lengths(path: FloatArray) -> FloatArray:
    """Return (n,) how far along a path each of its places lies."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])


def distances(places: FloatArray, path: FloatArray) -> FloatArray:
    """Return (n,) how far places (n, 2) lie from a path."""
    apart = places[:, None] - path[None]
    return np.asarray(np.hypot(apart[..., 0], apart[..., 1]).min(axis=1))


def left_of(path: FloatArray) -> FloatArray:
    """Return (n, 2) unit vectors across a path."""
    along = np.gradient(path, axis=0)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    return np.asarray(across / np.maximum(np.hypot(*along.T), 1e-9)[:, None])


def sampled(salience: MapArray, places: FloatArray) -> FloatArray:
    """Return the map at places (..., 2); 0 outside of it."""
    import cv2

    flat = np.ascontiguousarray(places.reshape(len(np.atleast_2d(places)), -1, 2), dtype=np.float32)
    found = cv2.remap(salience, flat, None, cv2.INTER_LINEAR, borderValue=0.0)
    return np.asarray(found, dtype=np.float64).reshape(places.shape[:-1])
