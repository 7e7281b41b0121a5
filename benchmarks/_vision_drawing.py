"""A scene drawn by distance: each pixel is cut into 4 x 4.

The nearest point on the dense true curve decides what each of these shows.
"""

from __future__ import annotations

import cv2
import numpy as np
from scipy.spatial import cKDTree

from benchmarks._vision_recipe import Recipe

SUB = 4
SWING_TIMES = 9  # of half a swing, from one side to the other


def draw(recipe: Recipe, rng, ideal, raw, s, K, dist, optics, rolls):
    """The picture, from what lies behind the sheet to the sensor's noise; fills in `rolls`."""
    w, h = recipe.size
    direction = 1.0 if recipe.bright else -1.0
    base = 50.0 if recipe.bright else 185.0
    contrast = recipe.contrast * direction
    picture = np.full((h, w), base)
    if recipe.clutter:
        picture = _clutter(picture, recipe, rng, contrast)
    picture = _spots(picture, recipe, rng, contrast)
    if recipe.wire:
        picture = _wire(picture, rng, ideal, contrast)
    if recipe.sheet:
        ground = picture
        picture = np.mean(
            [
                _sheet(
                    picture=ground,
                    recipe=recipe,
                    ideal=there,
                    s=s,
                    K=K,
                    dist=dist,
                    base=base,
                    contrast=contrast,
                )
                for there in _swung(ideal, s, recipe.swing_px)
            ],
            axis=0,
        )
    jaw = base + (0.6 if rng.random() < 0.5 else -0.25) * contrast
    if recipe.clamp:
        picture = _jaw(picture, recipe, raw, jaw)
    if recipe.rolls and recipe.sheet:
        picture = _rolls(picture, recipe, rng, raw, base, contrast, rolls)
        if rng.random() < 0.5:
            optics["rolls_px"] = rolls
    return _seen(picture, recipe, rng)


def _swung(ideal, s, swing_px):
    """Places of the sheet at equal times of a swing in its first mode, which is 0 at the clamp."""
    if swing_px == 0:
        return [ideal]
    tangent = np.gradient(ideal, axis=0)
    tangent /= np.hypot(*tangent.T)[:, None]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    beta = 1.8751 * s / s[-1]
    mode = np.cosh(beta) - np.cos(beta) - 0.7341 * (np.sinh(beta) - np.sin(beta))
    times = (np.arange(SWING_TIMES) + 0.5) / SWING_TIMES
    return [
        ideal + (swing_px * np.sin(np.pi * (t - 0.5)) * mode / mode[-1])[:, None] * normal
        for t in times
    ]


def _spots(picture, recipe, rng, contrast):
    """Blurred reflections on whatever is there."""
    h, w = picture.shape
    vv, uu = np.mgrid[0:h, 0:w]
    for _ in range(recipe.spots):
        a, b, r = rng.uniform(0, w), rng.uniform(0, h), rng.uniform(2, 9)
        picture += (
            rng.uniform(0.3, 1.0)
            * abs(contrast)
            * np.exp(-((uu - a) ** 2 + (vv - b) ** 2) / (2 * r * r))
        )
    return picture


def _wire(picture, rng, ideal, contrast):
    """A straight line across the sheet."""
    h, w = picture.shape
    p = ideal[int(rng.uniform(0.25, 0.9) * len(ideal))]
    a = rng.uniform(0, np.pi)
    d = np.array([np.cos(a), np.sin(a)]) * 900
    m = np.zeros((h, w), np.uint8)
    cv2.line(
        m,
        tuple(np.int32(p - d)),
        tuple(np.int32(p + d)),
        255,
        int(rng.integers(1, 4)),
        cv2.LINE_AA,
    )
    return picture + (m / 255.0) * contrast * rng.uniform(0.4, 1.0)


def _sheet(picture, recipe, ideal, s, K, dist, base, contrast):
    h, w = picture.shape
    raw = distort(ideal, K, dist)
    thick = max(recipe.thickness_mm, recipe.elongation_thickness_mm) * recipe.px_per_mm
    mask = np.zeros((h, w), np.uint8)
    pts = np.int32(np.round(raw * 16)).reshape(-1, 1, 2)
    reach = int(2 * (thick / 2 + 3 + (12 if recipe.face else 0))) + 2
    cv2.polylines(
        mask, [pts], isClosed=False, color=1, thickness=reach, lineType=cv2.LINE_8, shift=4
    )
    rows, columns = np.nonzero(mask)
    sub = (np.arange(SUB) + 0.5) / SUB - 0.5
    du, dv = np.meshgrid(sub, sub)
    raw_sub = np.stack(
        [columns[:, None] + du.ravel(), rows[:, None] + dv.ravel()], axis=-1
    ).reshape(-1, 2)
    flat = undistort(raw_sub, K, dist)
    fine = 0.02 * recipe.px_per_mm
    dense_s = np.arange(0, s[-1] * recipe.px_per_mm, fine) / recipe.px_per_mm
    dense = np.stack([np.interp(dense_s, s, ideal[:, i]) for i in range(2)], axis=1)
    half = np.where(dense_s <= recipe.free_mm, recipe.thickness_mm, recipe.elongation_thickness_mm)
    half = np.append(half, 0.0) / 2 * recipe.px_per_mm  # one more for places far from the sheet
    # a search that ends at the sheet's edge is many times faster, but a face needs every place's
    farthest = np.inf if recipe.face else half.max()
    distance, index = cKDTree(dense).query(flat, workers=1, distance_upper_bound=farthest)
    ends = (index > 0) & (index < len(dense) - 1)
    half = half[index]
    inside = (distance < half) & ends
    level = np.where(inside, 1.0, 0.0)
    if recipe.face:
        centre = np.array([w / 2, h / 2])
        far = centre + (dense - centre) * (1 - 0.0021 * 11)
        for share in np.linspace(0.05, 1, 14):
            mid = dense + (far - dense) * share
            left = np.flatnonzero(level == 0)
            d, j = cKDTree(mid).query(flat[left], workers=1, distance_upper_bound=half.max())
            face = (d < half[left]) & (j > 0) & (j < len(mid) - 1)
            level[left[face]] = recipe.face
    cover = level.reshape(-1, SUB * SUB).mean(axis=1)
    out = picture.copy()
    out[rows, columns] += cover * (base + contrast - out[rows, columns])
    return out


def _jaw(picture, recipe, raw, level):
    h, w = picture.shape
    c, sn = np.cos(recipe.roll_rad), np.sin(recipe.roll_rad)
    R = np.array([[c, -sn], [sn, c]])
    corners = np.array([[-14.0, -8], [0, -8], [0, 8], [-14, 8]]) * recipe.px_per_mm
    m = np.zeros((h, w), np.uint8)
    pts = raw[0] + corners @ R.T
    cv2.fillPoly(m, [np.int32(np.round(pts * 64))], 255, cv2.LINE_AA, 6)
    return picture * (1 - m / 255.0) + level * (m / 255.0)


def _rolls(picture, recipe, rng, raw, base, contrast, rolls):
    """Two discs that touch the sheet from both sides, and perhaps their holder before it."""
    h, w = picture.shape
    i = int(rng.uniform(0.55, 0.93) * (len(raw) - 1))
    tangent = raw[i + 20] - raw[i - 20]
    tangent /= np.hypot(*tangent)
    normal = np.array([-tangent[1], tangent[0]])
    radius = rng.uniform(8, 18)
    gap = recipe.thickness_mm * recipe.px_per_mm / 2 + rng.uniform(-0.5, 0.5)
    level = base + contrast * rng.uniform(-0.4, 1.1)
    for side in (-1, 1):
        centre = raw[i] + side * (radius + gap) * normal
        m = np.zeros((h, w), np.uint8)
        cv2.circle(
            m, tuple(np.int32(np.round(centre * 64))), int(radius * 64), 255, -1, cv2.LINE_AA, 6
        )
        picture = picture * (1 - m / 255.0) + level * (m / 255.0)
        rolls.append([float(centre[0]), float(centre[1]), float(radius)])
    if rng.random() < 0.6:  # the holder in front of the sheet hides up to 40 px of it
        m = np.zeros((h, w), np.uint8)
        half = rng.uniform(3, 20)
        a, b = raw[i] - half * tangent, raw[i] + half * tangent
        quad = np.array([a - 10 * normal, b - 10 * normal, b + 10 * normal, a + 10 * normal])
        cv2.fillPoly(m, [np.int32(np.round(quad * 64))], 255, cv2.LINE_AA, 6)
        picture = picture * (1 - m / 255.0) + level * (m / 255.0)
    return picture


def _seen(picture, recipe, rng):
    """What the camera makes of it: blur, uneven light, noise, steps of grey."""
    h, w = picture.shape
    vv, uu = np.mgrid[0:h, 0:w]
    picture = cv2.GaussianBlur(picture, (0, 0), recipe.blur_px)
    if recipe.uneven:
        a = rng.uniform(0, 2 * np.pi)
        ramp = ((uu - w / 2) * np.cos(a) + (vv - h / 2) * np.sin(a)) / w
        picture = picture * (1 + recipe.uneven * ramp)
    noise = recipe.contrast / recipe.snr
    picture = picture + rng.normal(0, noise, picture.shape)
    if recipe.bits == 16:
        return np.clip(np.round(picture * 256), 0, 65535).astype(np.uint16)
    return np.clip(np.round(picture), 0, 255).astype(np.uint8)


def _clutter(picture, recipe, rng, contrast):
    h, w = picture.shape
    out = picture.copy()
    for _ in range(recipe.clutter):
        m = np.zeros((h, w), np.uint8)
        kind = rng.integers(0, 4)
        a, b = rng.uniform(0, w), rng.uniform(0, h)
        if kind == 0:
            c, d = rng.uniform(0, w), rng.uniform(0, h)
            cv2.line(
                m, (int(a), int(b)), (int(c), int(d)), 255, int(rng.integers(1, 5)), cv2.LINE_AA
            )
        elif kind == 1:
            cv2.circle(
                m,
                (int(a), int(b)),
                int(rng.uniform(5, 60)),
                255,
                int(rng.choice([-1, 2, 3])),
                cv2.LINE_AA,
            )
        elif kind == 2:
            cv2.ellipse(
                m,
                (int(a), int(b)),
                (int(rng.uniform(20, 150)), int(rng.uniform(20, 150))),
                rng.uniform(0, 360),
                0,
                rng.uniform(60, 300),
                255,
                int(rng.integers(1, 4)),
                cv2.LINE_AA,
            )
        else:
            cv2.rectangle(
                m,
                (int(a), int(b)),
                (int(a + rng.uniform(10, 150)), int(b + rng.uniform(10, 150))),
                255,
                int(rng.choice([-1, 2])),
            )
        out += m / 255.0 * contrast * rng.uniform(-0.3, 1.0)
    return out


def distort(ideal, K, dist):
    n = np.column_stack([(ideal - K[:2, 2]) / (K[0, 0], K[1, 1]), np.ones(len(ideal))])
    out, _ = cv2.projectPoints(n.astype(float), np.zeros(3), np.zeros(3), K, dist)
    return np.asarray(out).reshape(-1, 2)


def undistort(raw, K, dist):
    if not dist.any():
        return raw
    out = cv2.undistortPoints(raw.reshape(-1, 1, 2).astype(float), K, dist, P=K)
    return np.asarray(out).reshape(-1, 2)
