"""Find where the sheet ends in the image, by its profile along and beyond the end of the curve."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.context import FitContext, pixels_beside
from labrig.vision.fit.curve_fit import CurveFit
from labrig.vision.thresholds import START_MISSING_MIN_SIGMAS

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class SheetEnd:
    """The visible end against the stated one, in pixels; None where it cannot be seen."""

    beyond_px: float | None  # positive: the sheet is longer than stated
    sigma_px: float = math.inf
    at_least: bool = False  # no end is seen: the sheet continues for at least `beyond_px`
    out_of_sight: bool = False  # the sheet is seen up to where the image or a roll ends


def find_sheet_end(fit: CurveFit, context: FitContext) -> SheetEnd:
    """Fit a step to the sheet's contrast along the curve, around its stated end."""
    total = fit.shape.basis.total_px
    before = min(60.0, 0.3 * total)
    after = max(16.0, 0.06 * total)
    at = np.arange(-round(before), round(after) + 1, dtype=float)
    ratio = _contrast_along(fit, context, at)
    seen = np.isfinite(ratio)
    beyond = seen & (at > 2)
    if seen[at < -3].sum() < 8 or beyond.sum() < 4:
        return SheetEnd(None, out_of_sight=bool(fit.used[-14:-4].mean() > 0.5))
    if np.mean(np.abs(ratio[beyond] - 1) < 0.45) > 0.85:
        return SheetEnd(float(at[seen][-1]), at_least=True)
    noise = _roughness(ratio[seen])
    places = np.arange(at[seen][0] + 6, at[seen][-1] - 3, 0.1)
    blur = math.hypot(fit.section.blur, 0.3)
    step = np.clip(0.5 + (places[:, None] - at[seen][None, :]) / (2.5 * blur), 0, 1)
    cost = np.minimum(((ratio[seen] - step) / noise) ** 2, 9.0).sum(axis=1)
    best = int(np.argmin(cost))
    # a step must explain more than a sheet that continues, or one that ended long before, does
    plain = min(cost[0], cost[-1])
    if best in (0, len(cost) - 1) or plain - cost[best] < 12:
        return SheetEnd(None)
    if places[best] < -4 and missing_end_px(fit) == 0:
        return SheetEnd(None)  # something hides the sheet there; that is no end
    return SheetEnd(float(places[best]), noise / math.sqrt(1 / (2.5 * blur)) + 0.2)


def missing_end_px(fit: CurveFit) -> float:
    """Return length at the end on which there is plain background where the sheet should be.

    0 where something is there that may hide it: what hides a sheet differs from its background.
    """
    edge = round(2.5 * fit.section.blur) + 1
    last = np.flatnonzero(fit.used)
    if len(last) < 20:
        return 0.0
    missing = np.arange(last[-1] + 1, len(fit.used) - edge)
    if len(missing) < 4:
        return 0.0
    contrast = fit.usual_contrast
    tail = last[-40:]
    ground = np.polyval(np.polyfit(tail, fit.cells[tail, 1], 1), missing)
    ground = np.clip(ground, *np.percentile(fit.cells[last, 1], [0, 100]))
    plain = np.abs(fit.cells[missing, 9] - ground) < 0.25 * contrast
    plain &= fit.in_view[missing]
    return float(len(missing)) * fit.shape.basis.step_px if plain.mean() > 0.7 else 0.0


def missing_start_px(fit: CurveFit, context: FitContext) -> float:
    """Return length at the clamp on which there is plain background where the sheet should be.

    0 where something is there that may hide it, or hardly any of it is missing.
    """
    edge = round(2.5 * fit.section.blur) + 1
    there = np.flatnonzero(fit.used)
    if len(there) < 20:
        return 0.0
    # the clamp's blurred edge, and what a neighbour that is seen may reach, are no evidence
    missing = np.arange(edge, there[0] - 2)
    missing = missing[fit.in_view[missing]]
    if (
        len(missing) * fit.shape.basis.step_px
        < START_MISSING_MIN_SIGMAS * context.optics.clamp_sigma_px
    ):
        return 0.0
    value, distance, first = pixels_beside(fit.shape, context, fit.section.reach)
    part = np.concatenate([np.arange(first[i], first[i + 1]) for i in missing])
    core = np.abs(distance[part]) < fit.section.half_width[0] + fit.section.blur
    if not core.any() or core.all():
        return 0.0
    level, sides = float(value[part][core].mean()), float(np.median(value[part][~core]))
    contrast = float(np.median(np.abs(fit.contrast[there[:40]])))
    ground = float(np.median(fit.cells[there[:40], 1]))
    plain = max(abs(sides - ground), abs(level - sides)) < 0.25 * contrast
    return float(there[0]) * fit.shape.basis.step_px if plain else 0.0


def _roughness(ratio: FloatArray) -> float:
    spread = float(np.median(np.abs(np.diff(ratio)))) / 0.6745 / math.sqrt(2)
    return max(0.08, 1.5 * spread)


def _contrast_along(fit: CurveFit, context: FitContext, at: FloatArray) -> FloatArray:
    """Return core minus flanks at distances `at` from the end, in units of the sheet's contrast."""
    import cv2

    shape, section = fit.shape, fit.section
    k, phi = float(shape.k[-8]), float(shape.phi[-1])
    angle = phi + k * at / 2
    x = shape.x[-1] + at * np.cos(angle)
    y = shape.y[-1] + at * np.sin(angle)
    half = float(section.half_width[-1])
    core = max(1.0, half)
    side = half + 2.5 * section.blur + 1.0
    across = np.concatenate([np.linspace(-core, core, 5) * 0.6, [-side - 1, -side, side, side + 1]])
    turn = phi + k * at
    px = x[:, None] - np.sin(turn)[:, None] * across
    py = y[:, None] + np.cos(turn)[:, None] * across
    plane = np.stack([px.ravel(), py.ravel()], axis=1)
    uv = context.optics.world_to_pixel(plane / context.optics.px_per_m).astype(np.float32)
    grey = context.image.grey
    shown = cv2.remap(
        grey,
        uv[:, 0].reshape(px.shape),
        uv[:, 1].reshape(px.shape),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=float("nan"),
    ).astype(float)
    covered = cv2.remap(
        context.mask,
        uv[:, 0].reshape(px.shape),
        uv[:, 1].reshape(px.shape),
        cv2.INTER_NEAREST,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=1.0,
    )
    raw = shown[:, :5].mean(axis=1) - shown[:, 5:].mean(axis=1)
    raw[covered.any(axis=1)] = np.nan
    inside = at < -4
    reference = float(np.nanmedian(raw[inside])) if np.isfinite(raw[inside]).any() else math.nan
    if not context.sign * reference > 0:
        return np.full(len(at), np.nan)
    return np.asarray(raw / reference)
