"""Put a curve and what stands out in the picture together, where both show one strip.

The curve is known to parts of a pixel but may end at a ring, a change of colour or a bend. What
stands out is coarse but whole. So it is followed, and drawn towards the curve by both sigmas. Where
the curve was bridged it stays so: what stands out there may be what hides the strip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve
from labrig.vision.extraction.outline_report import ASSUMED
from labrig.vision.extraction.salience.middle_line import MiddleLine, distances, left_of, lengths

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

PIXEL_SHARE, WIDTH_SHARE = 0.4, 0.03  # of the map's pixel and the strip's width: the middle's sigma
END_WIDTH_SHARE = 0.1  # of the width, and a pixel of the map: the end's sigma
PULL_SHARE, PULL_MAX_PX = 0.3, 3.0  # of the width: what clamp and tip may pull the middle
SAME_WIDTHS, SAME_SIGMAS, SAME_SHARE = 0.25, 2.0, 0.9  # so near, so much of it: the same course
SAME_WIDTH_RATIO = 1.35
SAME_END_SHARE, SAME_END_MIN_PX = 0.015, 3.0  # of the length: the same end
LEFT_WIDTHS = 2.0  # before the end of a curve that ends early it may have left the strip
LEFT_SIGMAS = 2.0  # and where it lies so far beside what stands out
END_SIGMA_MIN_PX = 0.1
KNOTS_WIDTHS, KNOTS_MIN, KNOTS_MAX = 1.0, 5, 60
WAVE_CURVATURE = math.pi**2  # over the square of the resolution: of a wave of twice that length
KNOWN_SHARE, KNOWN_MIN_PX = 0.25, 2.0  # of the width: no curve is known less well
POINT_PX = 1.0  # from point to point of the curve

LED_ON = (
    "the curve was led on to where the strip ceases to stand out in the picture; its sigma there "
    "is that of a coarse look"
)
CUT = (
    "the curve ends where the strip ceases to stand out in the picture; the edges were followed "
    "further, and the uncertainty of the end holds both"
)
GOES_ON = "the strip may go on"  # so a warning begins of an end that was looked at again


@dataclass(frozen=True, eq=False, kw_only=True)
class _Beside:
    """A curve beside a path, in pixels."""

    path_px: FloatArray
    sigma_px: FloatArray  # infinite where it does not count
    seen: BoolArray

    @property
    def bridged(self) -> BoolArray:
        """Return where it is not seen, and is seen again further on."""
        before = np.logical_or.accumulate(self.seen)
        after = np.logical_or.accumulate(self.seen[::-1])[::-1]
        return np.asarray(before & after & ~self.seen)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Middle:
    """A path with its standard deviation across and at its end, in pixels, and where it is seen."""

    path_px: FloatArray
    sigma_px: FloatArray
    seen: BoolArray
    end_sigma_px: float


def merged(first: NeutralCurve, look: MiddleLine, optics: Optics) -> NeutralCurve:
    """Return the curve with what stands out; as it is where both are not surely one strip."""
    px_per_m = lengths(first.points_px)[-1] / first.s_m[-1]
    width, own = first.thickness_m * px_per_m, _own_middle(look)
    at, total = _along(first.points_px, look.path_px), look.length_px
    common = look.wide_px[lengths(look.path_px) <= at[-1]]
    common = common[np.isfinite(common)]
    ratio = float(np.median(common)) / width if len(common) else 0.0
    if not 1 / SAME_WIDTH_RATIO < ratio < SAME_WIDTH_RATIO:
        return first
    near = SAME_WIDTHS * width + SAME_SIGMAS * float(np.median(own.sigma_px))
    beside = distances(first.points_px[at <= total], look.path_px)
    if not len(beside) or (beside < near).mean() < SAME_SHARE:
        return first
    more = total - float(at[-1])
    alike = max(SAME_END_SHARE * total, SAME_END_MIN_PX, 2 * own.end_sigma_px)
    curve = _Beside(path_px=first.points_px, sigma_px=first.sigma_m * px_per_m, seen=first.seen)
    if more > alike:
        before_end = lengths(first.points_px)[-1] - lengths(first.points_px)
        counts = np.clip(before_end / width - LEFT_WIDTHS, 0.0, 1.0)
        with np.errstate(divide="ignore"):
            curve = replace(curve, sigma_px=curve.sigma_px / counts)
        both = _drawn_towards(own, curve, most=LEFT_SIGMAS)
        return _curve(both, optics, first, width_px=width, note=LED_ON) or first
    both = _drawn_towards(own, curve)
    if more < -alike:
        # a thin or faint tail does not stand out, and nor does another thing that was followed
        both, note = replace(both, end_sigma_px=math.hypot(own.end_sigma_px, more)), CUT
    else:
        ends = (own.end_sigma_px, max(first.end_sigma_m * px_per_m, END_SIGMA_MIN_PX))
        end, end_sigma = _weighted((total, float(at[-1])), ends)
        both, note = replace(both, path_px=_cut(both.path_px, end), end_sigma_px=end_sigma), ""
    return _curve(both, optics, first, width_px=width, note=note) or first


def _own_middle(look: MiddleLine) -> _Middle:
    s, width = lengths(look.path_px), look.width_px
    inner = math.hypot(PIXEL_SHARE * look.pixel_px, WIDTH_SHARE * width)
    pull = min(PULL_SHARE * width, PULL_MAX_PX) * np.exp(-np.minimum(s, s[-1] - s) / width)
    pull = np.hypot(pull, PULL_MAX_PX * np.exp(-s / width))  # what is clamped stands out, too
    end = math.hypot(look.pixel_px, END_WIDTH_SHARE * width)
    return _Middle(
        path_px=look.path_px,
        sigma_px=np.hypot(inner, pull),
        seen=np.ones(len(s), dtype=bool),
        end_sigma_px=end,
    )


def _along(places: FloatArray, path: FloatArray) -> FloatArray:
    """Return (n,) how far along a path places lie; beyond its end it is led on straight."""
    apart = places[:, None] - path[None]
    nearest = np.hypot(apart[..., 0], apart[..., 1]).argmin(axis=1)
    ahead = path[-1] - path[-min(6, len(path))]
    ahead = ahead / max(float(np.hypot(*ahead)), 1e-9)
    beyond = np.maximum((places - path[-1]) @ ahead, 0.0)
    return np.asarray(lengths(path)[nearest] + np.where(nearest == len(path) - 1, beyond, 0.0))


def _drawn_towards(own: _Middle, curve: _Beside, *, most: float = math.inf) -> _Middle:
    """Return a path drawn towards a curve beside it, by what is known of both.

    `most`: standard deviations between both, beyond which the curve does not count.
    """
    across = left_of(own.path_px)
    apart = curve.path_px[None] - own.path_px[:, None]
    nearest = np.hypot(apart[..., 0], apart[..., 1]).argmin(axis=1)
    between = apart[np.arange(len(across)), nearest]
    offset = (between * across).sum(axis=1)
    lengthwise = np.abs(between[:, 0] * across[:, 1] - between[:, 1] * across[:, 0])
    other = np.where(lengthwise > 2 * POINT_PX, np.inf, curve.sigma_px[nearest])
    both = own.sigma_px**2 + other**2
    both = np.where(np.abs(offset) > most * np.sqrt(both), np.inf, both)
    counts = np.isfinite(both)
    weight = np.where(counts, own.sigma_px**2 / both, 0.0)
    sigma = own.sigma_px * np.sqrt((1 - weight) * np.maximum(1.0, offset**2 / both))
    hidden = counts & curve.bridged[nearest]
    return replace(
        own,
        path_px=own.path_px + (weight * offset)[:, None] * across,
        sigma_px=np.where(hidden, np.maximum(sigma, other), sigma),
        seen=np.where(counts, curve.seen[nearest], own.seen),
    )


def _warnings(first: NeutralCurve, note: str, curve: NeutralCurve) -> tuple[str, ...]:
    """Return the first curve's warnings, without what is no longer so of its end."""
    no_longer = (ASSUMED, GOES_ON) if note else (ASSUMED,)
    kept = [text for text in first.warnings if not text.startswith(no_longer)]
    found = (
        f"thickness {1e3 * curve.thickness_m:.2f} mm, length {1e3 * curve.s_m[-1]:.1f} mm "
        f"(to its end, ±{1e3 * curve.end_sigma_m:.1f} mm)"
    )
    return (*kept, ASSUMED + found, *([note] if note else []))


def halfway(path: FloatArray, other: FloatArray) -> FloatArray:
    """Return a path moved across itself, halfway to another one beside it."""
    one, beside = (
        {"path_px": each, "sigma_px": np.ones(len(each)), "seen": np.ones(len(each), dtype=bool)}
        for each in (path, other)
    )
    return _drawn_towards(_Middle(**one, end_sigma_px=0.0), _Beside(**beside)).path_px


def _weighted(places: tuple[float, float], sigmas: tuple[float, float]) -> tuple[float, float]:
    """Return the weighted mean of two places, and its standard deviation."""
    weights = np.array(sigmas) ** -2.0
    return float(weights @ places / weights.sum()), float(weights.sum() ** -0.5)


def _cut(path: FloatArray, end: float) -> FloatArray:
    """Return a path up to a place along it; beyond its end it is led on straight."""
    s = lengths(path)
    ahead = path[-1] - path[-min(6, len(path))]
    ahead = ahead / max(float(np.hypot(*ahead)), 1e-9)
    further = path[-1] + max(end - s[-1], 0.0) * ahead
    s, path = np.append(s, max(end, s[-1] + 1e-6)), np.vstack([path, further])
    even = np.linspace(0, end, len(path) - 1)
    return np.stack([np.interp(even, s, path[:, axis]) for axis in (0, 1)], axis=1)


def _curve(
    middle: _Middle, optics: Optics, first: NeutralCurve, *, width_px: float, note: str
) -> NeutralCurve | None:
    """Return a smooth curve through a path, in metres; None where it is not known well enough."""
    from scipy.interpolate import make_lsq_spline

    sigma_px = middle.sigma_px
    if sigma_px.max() > max(KNOWN_MIN_PX, KNOWN_SHARE * width_px) + PULL_MAX_PX:
        return None
    plane = optics.pixel_to_world(middle.path_px)
    s = lengths(plane)
    px_per_m = lengths(middle.path_px)[-1] / s[-1]
    pieces = int(np.clip(s[-1] * px_per_m / (KNOTS_WIDTHS * width_px), KNOTS_MIN, KNOTS_MAX))
    inner = np.linspace(0, s[-1], pieces + 1)[1:-1]
    knots = np.concatenate([[0.0] * 4, inner, [s[-1]] * 4])
    spline = make_lsq_spline(s, plane, knots, k=3)
    at = np.linspace(0, s[-1], max(30, round(s[-1] * px_per_m / POINT_PX)))
    (x, y), (dx, dy), (ddx, ddy) = (spline(at, order).T for order in (0, 1, 2))
    sigma_m = np.interp(at, s, sigma_px) / px_per_m
    resolution = s[-1] / pieces
    many = len(at)
    seen = np.interp(at, s, middle.seen) > 0.5
    curve = NeutralCurve(
        ok=True,
        s_m=lengths(np.stack([x, y], axis=1)),
        x_m=x,
        y_m=y,
        curvature_per_m=(dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3,
        sigma_m=sigma_m,
        curvature_sigma_per_m=WAVE_CURVATURE * sigma_m / resolution**2,
        curvature_resolution_m=resolution,
        points_px=optics.world_to_pixel(np.stack([x, y], axis=1)),
        seen=seen,
        covered=float(seen.mean()),
        end_sigma_m=middle.end_sigma_px / px_per_m,
        free_length_m=float(s[-1]),
        thickness_m=first.thickness_m,
        contrast=first.contrast,
        polarity=first.polarity,
        excess_px=np.zeros(many),
        lateral_bias_px=np.zeros(many),
        side_face_px=np.zeros(many),
    )
    return replace(curve, warnings=_warnings(first, note, curve))
