"""Find the two rolls beside the sheet: discs on both sides of the curve, by rims and centres.

Seen along their axes the rolls are two circles of one size that touch the sheet from both sides at
one place. Of all such pairs near a place of the curve the one is chosen whose rims are edges nearly
all round; then each rim's own edge points give its circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve
from labrig.vision.image.image import GreyImage, MapArray
from labrig.vision.thresholds import (
    ROLL_EDGE_MIN_RATIO,
    ROLL_EDGE_MIN_SIGMAS,
    ROLL_RADIUS_MAX_RATIO,
    ROLL_RESIDUAL_MAX_PX,
)

FloatArray = npt.NDArray[np.float64]

SEARCH_RANGE_M = 4e-3  # along the sheet, to either side of where the rolls should be
RADIUS_RANGE_M = (0.35e-3, 5e-3)
# rim angles from the direction away from the sheet; near the sheet its own edge is in the way
RIM_ANGLES_RAD = np.radians(np.linspace(-115, 115, 24))
RAY_ANGLES_RAD = np.radians(np.linspace(-115, 115, 64))
STEP_PX = 1.5  # an edge is looked for between this far inside and this far outside
SMOOTHED_NOISE = 0.28  # of a pixel's, after smoothing with a Gaussian of one pixel


@dataclass(frozen=True)
class Roll:
    """A circle in the world; `sigma_m` is its centre's, in each direction."""

    x_m: float
    y_m: float
    radius_m: float
    sigma_m: float


@dataclass(frozen=True, eq=False)
class _PlaneSampler:
    """An image sampled in the sheet's plane, lengths in pixels of that plane."""

    smooth: MapArray
    optics: Optics
    noise: float  # of the smoothed image

    def at(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return smoothed grey values; NaN outside of the image."""
        import cv2

        plane = np.stack([x.ravel(), y.ravel()], axis=1) / self.optics.px_per_m
        uv = self.optics.world_to_pixel(plane).astype(np.float32)
        flat = (-1, min(1024, len(uv)))
        pad = -len(uv) % flat[1]
        uv = np.pad(uv, ((0, pad), (0, 0)))
        shown = cv2.remap(
            self.smooth,
            uv[:, 0].reshape(flat),
            uv[:, 1].reshape(flat),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=float("nan"),
        )
        return np.asarray(shown.ravel()[: x.size].reshape(x.shape), dtype=np.float64)


def find_rolls(
    image: GreyImage, curve: NeutralCurve, optics: Optics, near_s_m: float
) -> tuple[Roll, Roll] | None:
    """Return the rolls beside the curve near `near_s_m`; None where no pair of discs is seen."""
    look = _PlaneSampler(image.smooth, optics, SMOOTHED_NOISE * image.noise)
    best = _best_pair(look, curve, near_s_m * optics.px_per_m)
    if best is None:
        return None
    first = _fitted(look, *best.centre(1.0), best, 1.0)
    second = _fitted(look, *best.centre(-1.0), best, -1.0)
    if first is None or second is None:
        return None
    larger, smaller = sorted((first.radius_m, second.radius_m), reverse=True)
    if larger > ROLL_RADIUS_MAX_RATIO * smaller:
        return None
    gap_px = optics.px_per_m * (
        math.hypot(first.x_m - second.x_m, first.y_m - second.y_m) - larger - smaller
    )
    # the sheet is between them, and nothing else
    if not -2.0 < gap_px < 2 * best.held_px + 4.0:
        return None
    return first, second


@dataclass(frozen=True, kw_only=True)
class _Pair:
    """Where both rolls may be: the place between them, the sheet's direction, their radius."""

    x: float
    y: float
    angle: float
    radius: float
    held_px: float  # half the thickness of what they hold
    sign: float  # +1: brighter than what is around them

    def centre(self, side: float) -> tuple[float, float]:
        away = side * (self.radius + self.held_px)
        return self.x - away * math.sin(self.angle), self.y + away * math.cos(self.angle)


def _best_pair(look: _PlaneSampler, curve: NeutralCurve, near: float) -> _Pair | None:
    ppm = look.optics.px_per_m
    s = curve.s_m * ppm
    places = np.arange(near - SEARCH_RANGE_M * ppm, near + SEARCH_RANGE_M * ppm + 0.5, 1.0)
    places = places[(places > s[0] + 5) & (places < s[-1])]
    if not len(places):
        return None
    x, y = (np.interp(places, s, values * ppm) for values in (curve.x_m, curve.y_m))
    angle = np.interp(places, s, _angles(curve))
    held = np.interp(places, s, _half_widths_px(curve, ppm))
    radius = _radii_px(ppm)
    edges = np.stack([_rim_edges(look, x, y, angle, held, radius, side) for side in (1.0, -1.0)])
    quarter = RIM_ANGLES_RAD.size // 4
    # both rims together, three quarters of each: one straight edge is no roll
    scores = [np.partition(q * edges, quarter, axis=-1)[..., quarter].min(axis=0) for q in (1, -1)]
    sign = 0 if scores[0].max() >= scores[1].max() else 1
    i, j = np.unravel_index(int(np.argmax(scores[sign])), scores[sign].shape)
    least = max(ROLL_EDGE_MIN_SIGMAS * look.noise, ROLL_EDGE_MIN_RATIO * curve.contrast)
    if not scores[sign][i, j] > least:
        return None
    return _Pair(
        x=float(x[i]),
        y=float(y[i]),
        angle=float(angle[i]),
        radius=float(radius[j]),
        held_px=float(held[i]),
        sign=1.0 - 2 * sign,
    )


def _angles(curve: NeutralCurve) -> FloatArray:
    return np.unwrap(np.arctan2(np.gradient(curve.y_m), np.gradient(curve.x_m)))


def _half_widths_px(curve: NeutralCurve, px_per_m: float) -> FloatArray:
    """Return (points,) half the visible thickness."""
    sheet = np.full(len(curve.s_m), curve.thickness_m * px_per_m / 2)
    beyond = curve.s_m > curve.free_length_m
    return np.where(beyond, max(curve.elongation_width_px / 2, sheet[0]), sheet)


def _radii_px(px_per_m: float) -> FloatArray:
    least, most = max(2.5, RADIUS_RANGE_M[0] * px_per_m), max(4.0, RADIUS_RANGE_M[1] * px_per_m)
    radii = [least]
    while radii[-1] < most:
        radii.append(radii[-1] + max(0.8, 0.07 * radii[-1]))
    return np.array(radii)


def _rim_edges(
    look: _PlaneSampler,
    x: FloatArray,
    y: FloatArray,
    angle: FloatArray,
    held: FloatArray,
    radius: FloatArray,
    side: float,
) -> FloatArray:
    """Return (places, radii, angles): inside minus outside of the rim of a roll at one side."""
    away = side * (radius[None, :] + held[:, None])
    u = x[:, None] - away * np.sin(angle)[:, None]
    v = y[:, None] + away * np.cos(angle)[:, None]
    turn = angle[:, None] + side * np.pi / 2 + RIM_ANGLES_RAD[None, :]  # (places, angles)
    c, s = np.cos(turn)[:, None, :], np.sin(turn)[:, None, :]
    levels = []
    for reach in (radius - STEP_PX, radius + STEP_PX):
        far = reach[None, :, None]
        levels.append(look.at(u[:, :, None] + far * c, v[:, :, None] + far * s))
    return np.nan_to_num(levels[0] - levels[1], nan=0.0)


def _fitted(look: _PlaneSampler, u: float, v: float, pair: _Pair, side: float) -> Roll | None:
    """Return the circle through the rim's own edge points; None where they are on none."""
    turn = pair.angle + side * np.pi / 2 + RAY_ANGLES_RAD
    reach = min(4.0, 0.5 * pair.radius + 1.0)
    radial = np.arange(-reach, reach + 0.01, 0.25)
    centre, radius = np.array([u, v]), pair.radius
    residual, kept = np.inf, 0
    for _ in range(3):
        out = radius + radial
        ray = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        x, y = (centre[q] + out[None, :] * ray[:, q : q + 1] for q in range(2))
        edge = _neighbours(-pair.sign * np.gradient(look.at(x, y), axis=1))
        # of several edges the one nearest to where it should be, unless another is much stronger
        worth = edge * np.exp(-((radial / reach) ** 2))
        peak = np.argmax(np.nan_to_num(worth, nan=-np.inf), axis=1)
        strong = np.take_along_axis(edge, peak[:, None], axis=1)[:, 0]
        inner = (peak > 0) & (peak < len(radial) - 1) & np.isfinite(strong)
        good = inner & (strong > 0.4 * np.nanmedian(strong[inner]) if inner.any() else inner)
        if good.sum() < RAY_ANGLES_RAD.size // 2:
            return None
        at = out[peak[good]] + 0.25 * _peak_offset(edge[good], peak[good])
        points = centre + at[:, None] * ray[good]
        centre, radius, residual, kept = _circle(points)
    if residual > ROLL_RESIDUAL_MAX_PX or math.hypot(centre[0] - u, centre[1] - v) > 3 + reach:
        return None
    ppm = look.optics.px_per_m
    # neighbouring rays share their noise
    sigma = max(0.05, 2 * residual / math.sqrt(kept / 6))
    return Roll(float(centre[0]) / ppm, float(centre[1]) / ppm, radius / ppm, sigma / ppm)


def _neighbours(rays: FloatArray) -> FloatArray:
    """Return each ray's mean with those beside it: a rim is smooth, noise is not."""
    padded = np.pad(rays, ((2, 2), (0, 0)), mode="edge")
    return np.asarray(sum(padded[q : q + len(rays)] for q in range(5)) / 5)


def _peak_offset(edge: FloatArray, peak: npt.NDArray[np.intp]) -> FloatArray:
    """Return the sub-sample place of each row's peak, by a parabola."""
    rows = np.arange(len(edge))
    left, middle, right = (edge[rows, peak + q] for q in (-1, 0, 1))
    bend = left - 2 * middle + right
    return np.where(bend < 0, 0.5 * (left - right) / np.minimum(bend, -1e-12), 0.0)


def _circle(points: FloatArray) -> tuple[FloatArray, float, float, int]:
    """Return centre, radius, RMS residual and number of the points that count; outliers do not."""
    weight = np.ones(len(points))
    centre, radius, off = points.mean(axis=0), 1.0, np.zeros(len(points))
    for _ in range(4):
        table = np.column_stack([2 * points, np.ones(len(points))]) * weight[:, None]
        right = (points**2).sum(axis=1) * weight
        a, b, c = np.linalg.lstsq(table, right, rcond=None)[0]
        centre, radius = np.array([a, b]), math.sqrt(max(c + a * a + b * b, 1e-9))
        off = np.hypot(*(points - centre).T) - radius
        spread = max(0.1, 1.48 * float(np.median(np.abs(off))))
        weight = (1 - np.minimum(np.abs(off) / (4.7 * spread), 1.0) ** 2) ** 2
    kept = weight > 0.1
    return centre, radius, float(np.sqrt(np.mean(off[kept] ** 2))), int(kept.sum())
