"""Pictures of bent sheets with known truth, for judging the extractor. Shares no code with it.

What they hold is drawn at random from a `Recipe`: cameras, lights, clamps, rolls, spots, wires and
grey faces. Every pixel is cut into small ones, then the lens blurs and the sensor adds noise.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import cv2
import numpy as np
from scipy.spatial import cKDTree

from benchmarks._vision_drawing import distort, draw
from benchmarks._vision_recipe import Recipe, mixed
from benchmarks._vision_truth import does_not_touch_itself, truth_curve

__all__ = ["Recipe", "Scene", "make_scene", "mixed", "rmse_px", "save"]


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
        if ((ideal > 12) & (ideal < np.array([w, h]) - 12)).all() and does_not_touch_itself(xy):
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
    raw = distort(ideal, K, dist)
    jitter = rng.normal(0, 0.6, 2) if recipe.jitter else np.zeros(2)
    optics["clamp_px"] = (raw[0] + jitter).tolist()
    optics["clamp_angle_rad"] = float(rng.normal(0, 0.008)) if recipe.jitter else 0.0
    rolls: list[list[float]] = []
    image = draw(
        recipe=recipe,
        rng=rng,
        ideal=ideal,
        raw=raw,
        s=s,
        K=K,
        dist=dist,
        optics=optics,
        rolls=rolls,
    )
    strip = {
        "free_length_mm": recipe.free_mm,
        "elongation_mm": recipe.elongation_mm,
        "thickness_mm": recipe.thickness_mm,
    }
    return Scene(
        image=image,
        optics=optics,
        strip=strip,
        truth_mm=xy,
        truth_px=raw,
        s_mm=s,
        k_per_m=k,
        recipe=recipe,
        rolls_px=rolls,
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
