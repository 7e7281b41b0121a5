"""Pictures of bent sheets with known truth, for judging the extractor. Shares no code with it.

A scene is drawn by distance: each pixel is cut into 4 x 4, every part's nearest point on a dense
truth curve decides what it shows; then the lens blurs and the sensor adds noise. Cameras, lights,
clamps, rolls, spots, wires and grey faces are drawn at random from `Recipe`.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import cv2
import numpy as np
from scipy.spatial import cKDTree

SUB = 4


@dataclass
class Recipe:
    """What a scene holds. The defaults are a plain long sheet, flat and calibrated."""

    seed: int = 0
    size: tuple[int, int] = (640, 480)
    px_per_mm: float = 8.9
    free_mm: float = 50.0
    elongation_mm: float = 0.0
    thickness_mm: float = 0.21
    elongation_thickness_mm: float = 0.5
    snr: float = 20.0
    contrast: float = 120.0
    bright: bool = True
    blur_px: float = 0.9
    roll_rad: float = 0.0
    lens: bool = False
    rolls: bool = False
    clamp: bool = True
    spots: int = 0
    wire: bool = False
    uneven: float = 0.0
    face: float = 0.0  # grey of the far face, share of the contrast
    turn_rad: float | None = None  # total bend; None: at random
    jitter: bool = True  # of clamp_px and angle as written into optics
    sheet: bool = True
    clutter: int = 0
    bits: int = 8
    place: tuple[float, float] | None = None
    physical: bool = False  # curvature as the gel's model has it, not at random
    extra: dict = field(default_factory=dict)


@dataclass
class Scene:
    image: np.ndarray
    optics: dict
    strip: dict
    truth_mm: np.ndarray  # (n, 2)
    truth_px: np.ndarray  # (n, 2) raw pixels
    s_mm: np.ndarray
    k_per_m: np.ndarray
    recipe: Recipe
    rolls_px: list[list[float]] = field(default_factory=list)  # u, v, radius as drawn


def truth_curve(recipe: Recipe, rng):
    """Curvature as beams and gels have it: exponentials along the sheet plus a contact's kink."""
    n = 4001
    length = recipe.free_mm + recipe.elongation_mm
    s = np.linspace(0, length, n)
    if recipe.physical:
        return _gel_curve(recipe, rng, s)
    free = s <= recipe.free_mm
    t = s / recipe.free_mm
    k = rng.normal(0, 1) + 1.5 * rng.normal() * np.exp(-t / rng.uniform(0.2, 0.9))
    k = k + 0.6 * rng.normal() * np.sin(np.pi * t * rng.uniform(0.5, 1.6) + rng.uniform(0, 6))
    where = rng.uniform(0.5, 0.95)
    k = k + rng.normal() * np.maximum(0, where - t)
    k = np.where(free, k, 0.0)
    ds = s[1] - s[0]
    turn = recipe.turn_rad if recipe.turn_rad is not None else rng.uniform(-4.19, 4.19)
    phi = np.concatenate([[0], np.cumsum((k[1:] + k[:-1]) / 2 * ds)])
    scale = turn / phi[-1] if abs(phi[-1]) > 0.3 * np.abs(phi).max() else 1.0 / np.abs(phi).max()
    k, phi = k * scale, phi * scale
    x = np.concatenate([[0], np.cumsum((np.cos(phi[1:]) + np.cos(phi[:-1])) / 2 * ds)])
    y = np.concatenate([[0], np.cumsum((np.sin(phi[1:]) + np.sin(phi[:-1])) / 2 * ds)])
    return s, np.stack([x, y], axis=1), k * 1000, phi


def _gel_curve(recipe, rng, s):
    """Initial curvature, a moment that decays from the root, and a force at a contact."""
    k = 24 * rng.uniform(0.8, 1.2) * np.exp(-s / 40)
    k = k + rng.choice([-80, 0, 100]) * rng.uniform(0.8, 1.2) * np.exp(-s / rng.uniform(9, 16))
    contact = rng.uniform(36, 44)
    k = k + rng.normal(0, 15) * np.maximum(0, 1 - s / contact)
    k = np.where(s <= recipe.free_mm, k, 0.0) * rng.choice([-1, 1]) / 1000
    ds = s[1] - s[0]
    phi = np.concatenate([[0], np.cumsum((k[1:] + k[:-1]) / 2 * ds)])
    x = np.concatenate([[0], np.cumsum((np.cos(phi[1:]) + np.cos(phi[:-1])) / 2 * ds)])
    y = np.concatenate([[0], np.cumsum((np.sin(phi[1:]) + np.sin(phi[:-1])) / 2 * ds)])
    return s, np.stack([x, y], axis=1), k * 1000, phi


def make_scene(recipe: Recipe) -> Scene:
    rng = np.random.default_rng(recipe.seed)
    w, h = recipe.size
    for _ in range(200):
        s, xy, k, _ = truth_curve(recipe, rng)
        if np.abs(k).max() > 200 or ((xy[200:, 0] < 0.5) & (np.abs(xy[200:, 1]) < 9)).any():
            continue
        origin = np.array(recipe.place or (rng.uniform(0.08, 0.5) * w, rng.uniform(0.2, 0.8) * h))
        c, sn = np.cos(recipe.roll_rad), np.sin(recipe.roll_rad)
        ideal = origin + recipe.px_per_mm * (xy * (1, -1)) @ np.array([[c, -sn], [sn, c]]).T
        if ((ideal > 12) & (ideal < np.array([w, h]) - 12)).all() and _no_touch(xy):
            break
        if recipe.place is not None:
            recipe.place = None
    else:
        raise RuntimeError("no curve fits into the picture")
    K = np.array([[w * 1.1, 0, w / 2 - 3.3], [0, w * 1.1, h / 2 + 2.1], [0, 0, 1.0]])
    dist = np.array([-0.12, 0.08, 0.0006, -0.0004, 0.0]) if recipe.lens else np.zeros(5)
    optics = {
        "image_size": [w, h],
        "px_per_mm": recipe.px_per_mm,
        "px_per_mm_sigma": 0.0,
        "roll_rad": recipe.roll_rad,
        "origin_px": origin.tolist(),
        "bits": recipe.bits,
        "polarity": "auto",
    }
    if recipe.lens:
        optics["camera_matrix"] = K.tolist()
        optics["distortion"] = dist.tolist()
    raw = _distort(ideal, K, dist)
    jitter = rng.normal(0, 0.6, 2) if recipe.jitter else np.zeros(2)
    optics["clamp_px"] = (raw[0] + jitter).tolist()
    optics["clamp_angle_rad"] = float(rng.normal(0, 0.008)) if recipe.jitter else 0.0
    rolls: list[list[float]] = []
    image = _draw(recipe, rng, ideal, raw, s, K, dist, optics, rolls)
    strip = {
        "free_length_mm": recipe.free_mm,
        "elongation_mm": recipe.elongation_mm,
        "thickness_mm": recipe.thickness_mm,
    }
    return Scene(image, optics, strip, xy, raw, s, k, recipe, rolls)


def _no_touch(xy):
    p = xy[::40]
    d = np.hypot(*(p[:, None] - p[None]).transpose(2, 0, 1))
    i = np.arange(len(p))
    far = np.abs(i[:, None] - i[None]) * 40 * (50 / 4000) > 8
    return not (d[far] < 4).any()


def _distort(ideal, K, dist):
    n = np.column_stack([(ideal - K[:2, 2]) / (K[0, 0], K[1, 1]), np.ones(len(ideal))])
    out, _ = cv2.projectPoints(n.astype(float), np.zeros(3), np.zeros(3), K, dist)
    return np.asarray(out).reshape(-1, 2)


def _undistort(raw, K, dist):
    if not dist.any():
        return raw
    out = cv2.undistortPoints(raw.reshape(-1, 1, 2).astype(float), K, dist, P=K)
    return np.asarray(out).reshape(-1, 2)


def _draw(recipe, rng, ideal, raw, s, K, dist, optics, rolls):
    w, h = recipe.size
    direction = 1.0 if recipe.bright else -1.0
    base = 50.0 if recipe.bright else 185.0
    contrast = recipe.contrast * direction
    vv, uu = np.mgrid[0:h, 0:w]
    picture = np.full((h, w), base)
    if recipe.clutter:
        picture = _clutter(picture, recipe, rng, contrast)
    for _ in range(recipe.spots):  # blurred reflections on whatever is there
        a, b, r = rng.uniform(0, w), rng.uniform(0, h), rng.uniform(2, 9)
        picture += (
            rng.uniform(0.3, 1.0)
            * abs(contrast)
            * np.exp(-((uu - a) ** 2 + (vv - b) ** 2) / (2 * r * r))
        )
    if recipe.wire:
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
        picture += (m / 255.0) * contrast * rng.uniform(0.4, 1.0)
    if recipe.sheet:
        picture = _sheet(picture, recipe, ideal, s, K, dist, base, contrast)
    jaw = base + (0.6 if rng.random() < 0.5 else -0.25) * recipe.contrast * (
        1 if recipe.bright else -1
    )
    c, sn = np.cos(recipe.roll_rad), np.sin(recipe.roll_rad)
    if recipe.clamp:
        R = np.array([[c, -sn], [sn, c]])
        corners = np.array([[-14.0, -8], [0, -8], [0, 8], [-14, 8]]) * recipe.px_per_mm
        m = np.zeros((h, w), np.uint8)
        pts = raw[0] + corners @ R.T
        cv2.fillPoly(m, [np.int32(np.round(pts * 64))], 255, cv2.LINE_AA, 6)
        picture = picture * (1 - m / 255.0) + jaw * (m / 255.0)
    if recipe.rolls and recipe.sheet:
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
        if rng.random() < 0.5:
            optics["rolls_px"] = rolls
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


def _sheet(picture, recipe, ideal, s, K, dist, base, contrast):
    h, w = picture.shape
    raw = _distort(ideal, K, dist)
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
    flat = _undistort(raw_sub, K, dist)
    fine = 0.02 * recipe.px_per_mm
    dense_s = np.arange(0, s[-1] * recipe.px_per_mm, fine) / recipe.px_per_mm
    dense = np.stack([np.interp(dense_s, s, ideal[:, i]) for i in range(2)], axis=1)
    distance, index = cKDTree(dense).query(flat, workers=1)
    half = np.where(dense_s <= recipe.free_mm, recipe.thickness_mm, recipe.elongation_thickness_mm)
    half = half[index] / 2 * recipe.px_per_mm
    ends = (index > 0) & (index < len(dense) - 1)
    inside = (distance < half) & ends
    level = np.where(inside, 1.0, 0.0)
    if recipe.face:
        centre = np.array([w / 2, h / 2])
        far = centre + (dense - centre) * (1 - 0.0021 * 11)
        for share in np.linspace(0.05, 1, 14):
            mid = dense + (far - dense) * share
            d, j = cKDTree(mid).query(flat, workers=1)
            face = (d < half) & ~inside & (j > 0) & (j < len(mid) - 1)
            level = np.where(face, recipe.face, level)
    cover = level.reshape(-1, SUB * SUB).mean(axis=1)
    out = picture.copy()
    out[rows, columns] += cover * (base + contrast - out[rows, columns])
    return out


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


def mixed(seed: int) -> Recipe:
    """A random scene of the mixed kind: everything a rig may show, within what is asked for."""
    rng = np.random.default_rng(10_000 + seed)
    short = rng.random() < 0.35
    return Recipe(
        seed=seed,
        snr=float(rng.choice([5, 8, 10, 15, 20, 30, 40])),
        contrast=float(rng.uniform(70, 130)),
        bright=bool(rng.random() < 0.5),
        blur_px=float(rng.uniform(0.6, 1.4)),
        roll_rad=float(rng.normal(0, 0.02)),
        lens=bool(rng.random() < 0.4),
        rolls=bool(rng.random() < 0.6),
        spots=int(rng.integers(0, 5)),
        wire=bool(rng.random() < 0.25),
        uneven=float(rng.uniform(0, 0.5)),
        free_mm=4.5 if short else 50.0,
        elongation_mm=40.0 if short else 0.0,
        elongation_thickness_mm=float(rng.choice([0.21, 0.5, 0.8])),
        turn_rad=float(rng.uniform(-0.7, 0.7)) if short else float(rng.uniform(-4.19, 4.19)),
    )


def rmse_px(found_px: np.ndarray, truth_px: np.ndarray) -> float:
    """RMS orthogonal distance of the found points to the dense truth, its ends prolonged."""
    head = (
        truth_px[0]
        + (truth_px[0] - truth_px[4])
        / np.hypot(*(truth_px[0] - truth_px[4]))
        * np.linspace(40, 0.05, 800)[:, None]
    )
    tail = (
        truth_px[-1]
        + (truth_px[-1] - truth_px[-5])
        / np.hypot(*(truth_px[-1] - truth_px[-5]))
        * np.linspace(0.05, 40, 800)[:, None]
    )
    line = np.vstack([head, truth_px, tail])
    _, index = cKDTree(line).query(found_px)
    index = np.clip(index, 1, len(line) - 2)
    tangent = line[index + 1] - line[index - 1]
    tangent /= np.hypot(*tangent.T)[:, None]
    d = found_px - line[index]
    return float(np.sqrt(np.mean((d[:, 0] * -tangent[:, 1] + d[:, 1] * tangent[:, 0]) ** 2)))


def save(scene: Scene, folder, name: str) -> None:
    cv2.imwrite(str(folder / f"{name}.png"), scene.image)
    (folder / f"{name}.optics.json").write_text(json.dumps(scene.optics))
    lines = "\n".join(f"{k} = {v}" for k, v in scene.strip.items())
    (folder / f"{name}.sheet.toml").write_text(lines + "\n")
