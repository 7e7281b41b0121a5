"""Find straight lines that are no sheet, such as wires: they reach the border or leave a curve.

Where one runs along the sheet no pixel tells the two apart, but everywhere else it does: a wire is
found at the border, where no sheet is, or beside a curve, which no sheet leaves; it is followed
straight through the image, and its pixels are left out, as those of the rolls are.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.curve.background_lines import DIRECTION_NODES, BackgroundLine
from labrig.vision.image.image import GreyImage
from labrig.vision.search.ridge_tracing import RidgeMaps
from labrig.vision.search.straight_ridges import entries, followed
from labrig.vision.thresholds import BRANCH_GAP_MAX_PX, LINE_GAP_MAX_PX, LINE_TWO_SIDED_SHARE_MIN

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]
BoolArray = npt.NDArray[np.bool_]

RING_INSETS_PX = (3, 8, 13)  # of the rings on which wires are looked for, from the border
# from what is used beside a curve to where another thing is seen; in the maps
OUTSIDE_DISTANCE_PX = 4.0
WIDTH_REACH_PX = 8
FLANK_MARGIN_PX = 1.2  # beyond half its width at half height: the blurred flank


def find_wires(image: GreyImage, ridges: RidgeMaps, sign: float) -> list[BackgroundLine]:
    """Return the straight ridges of a sign that reach the image's border."""
    maps = ridges.maps[:1]
    found: list[BackgroundLine] = []
    for entry in (
        entry for inset in RING_INSETS_PX for entry in _from_border(maps[0], sign, inset)
    ):
        if not any(wire.shows_at(ridges.raw(entry[:2])) for wire in found):
            u, v, angle, inset = (float(value) for value in entry)
            line = followed(maps, sign, u, v, angle, inset, LINE_GAP_MAX_PX)
            found += _wire(image, ridges, line, sign)
    return found


def find_branches(
    image: GreyImage,
    ridges: RidgeMaps,
    sign: float,
    curve: FloatArray,
    seen: BoolArray,
    apart: float,
) -> list[BackgroundLine]:
    """Return the straight ridges that leave a curve (n, 2): that are seen `apart` from it.

    A sheet does not branch: a line that runs with the curve and continues where that bends away is
    no part of it, wherever its ends are. `seen` (n - 1,): where the curve looks like a sheet.
    """
    maps = ridges.maps[:1]
    found: list[BackgroundLine] = []
    from_gaps = _from_gaps(ridges, curve, seen)
    for u, v, angle in from_gaps + _from_curve(ridges, sign, curve, apart):
        if any(wire.shows_at(ridges.raw(np.array([u, v]))) for wire in found):
            continue
        away = followed(maps, sign, u, v, angle, 0.0, BRANCH_GAP_MAX_PX)
        if away is not None:
            # from its far end back, so that what lies along the curve belongs to it, too
            (du, dv), (far_u, far_v) = away[0][0] - away[0][-1], away[0][-1]
            line = followed(maps, sign, far_u, far_v, math.atan2(dv, du), 0.0, BRANCH_GAP_MAX_PX)
            found += _wire(image, ridges, line, sign)
    return found


def _wire(
    image: GreyImage, ridges: RidgeMaps, line: tuple[FloatArray, BoolArray] | None, sign: float
) -> list[BackgroundLine]:
    """Return the wire of a line in the ridge maps; none where it is an edge."""
    if line is None:
        return []
    path = ridges.raw(line[0])
    half = _half_width(image, path, sign, ridges.scale)
    return [BackgroundLine(path, line[1], half)] if half is not None else []


def _from_border(layer: MapArray, sign: float, inset: int) -> list[FloatArray]:
    """Return where ridges come in: u, v, inward angle and inset."""
    rows, columns = layer.shape[1:]
    right, bottom = columns - 1 - inset, rows - 1 - inset
    across, down = np.arange(inset, right), np.arange(inset, bottom)
    if len(across) < 40 or len(down) < 40:
        return []
    one, other = np.ones_like(across), np.ones_like(down)
    u = np.concatenate([across, right * other, across[::-1] + 1, inset * other])
    v = np.concatenate([inset * one, down, bottom * one, down[::-1] + 1])
    found = entries(layer, sign, u, v)
    inwards = np.array([columns / 2, rows / 2]) - found[:, :2]
    return [np.append(entry, inset) for entry in _turned(found, inwards)]


def _from_curve(
    ridges: RidgeMaps, sign: float, curve: FloatArray, beside: float
) -> list[FloatArray]:
    """Return where ridges cross the lines `beside` a curve: u, v and the angle away from it."""
    ahead = np.gradient(curve, axis=0)
    normal = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    normal *= beside / np.hypot(ahead[:, 0], ahead[:, 1])[:, None]
    ring = np.concatenate([curve + normal, (curve - normal)[::-1]])
    foot = np.concatenate([curve, curve[::-1]])
    gap = ring[::4, None] - curve[None, ::4]
    alone = np.hypot(gap[..., 0], gap[..., 1]).min(axis=1) > beside - 2
    alone = np.repeat(alone, 4)[: len(ring)]
    place = np.round((ring + 0.5) / ridges.scale - 0.5).astype(np.int64)
    rows, columns = ridges.maps.shape[2:]
    inside = ((place >= 0) & (place < (columns, rows))).all(axis=1)
    kept = alone & inside
    if kept.sum() < 9:
        return []
    found = entries(ridges.maps[0], sign, *place[kept].T)
    away = (ring - foot)[kept]
    nearest = np.hypot(*(found[:, None, :2] - place[kept][None]).transpose(2, 0, 1)).argmin(axis=1)
    return list(_turned(found, away[nearest]))


def _from_gaps(ridges: RidgeMaps, curve: FloatArray, seen: BoolArray) -> list[FloatArray]:
    """Return where gaps in a curve begin and end.

    U, v and the angle of what is seen, into the gap.
    """
    ends = np.flatnonzero(np.diff(seen.astype(int)))[1:-1] + 1  # the clamp and the sheet's own end
    found = []
    for end in ends:
        before = bool(seen[end - 1])
        inside = np.clip(
            end - DIRECTION_NODES if before else end + DIRECTION_NODES, 0, len(curve) - 1
        )
        du, dv = curve[end] - curve[inside]
        place = (curve[end] + 0.5) / ridges.scale - 0.5
        found.append(np.append(place, math.atan2(dv, du)))
    return found


def _turned(found: FloatArray, to: FloatArray) -> FloatArray:
    """Return entries turned round where they would not lead to the side of `to` (n, 2)."""
    back = np.cos(found[:, 2]) * to[:, 0] + np.sin(found[:, 2]) * to[:, 1] < 0
    return found + np.outer(back, [0.0, 0.0, math.pi])


def _half_width(image: GreyImage, path: FloatArray, sign: float, scale: int) -> float | None:
    """Return half of what is seen of it across; None for an edge, which has no other side."""
    from labrig.vision.search.ridge_points import ridge_offsets

    ahead = np.gradient(path, axis=0)
    ahead /= np.hypot(ahead[:, 0], ahead[:, 1])[:, None]
    u, v = np.ascontiguousarray(path.T)
    reach = np.full(len(u), WIDTH_REACH_PX * scale)
    across = (-ahead[:, 1].copy(), ahead[:, 0].copy())
    _, height, width = ridge_offsets(image.smooth, u, v, *across, reach, sign)
    good = np.isfinite(width) & (height > image.noise)
    if good.mean() < LINE_TWO_SIDED_SHARE_MIN:
        return None
    return 0.5 * float(np.median(width[good])) + FLANK_MARGIN_PX
