"""Small pictures of one or two strips, with what is known of them, as files."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np

from labrig.extractors.examples import STRIP, Example, examples

BENT_UP, BENT_DOWN = (next(e for e in examples() if e.name == name) for name in (
    "a bright strip bent up", "a dark strip bent down"
))  # fmt: skip


def bright_down() -> np.ndarray:
    """The strip that is bent down, drawn bright on the same ground."""
    return np.clip(180.0 - BENT_DOWN.image.astype(float), 0, 255).astype(np.uint8)


REFLECTED_PX = 12  # rows from the strip to its reflection


def with_reflection() -> np.ndarray:
    """The strip that is bent up, and below it a second one, nearly as bright."""
    light = BENT_UP.image.astype(float) - np.median(BENT_UP.image)
    return np.clip(BENT_UP.image + 0.9 * np.roll(light, REFLECTED_PX, axis=0), 0, 255).astype(
        np.uint8
    )


def over_reflection() -> list[tuple[float, float]]:
    """A polygon over that second one."""
    arc = _places(np.linspace(-0.001, 0.031, 9))
    below, above = (np.add(arc, (0.0, REFLECTED_PX + side)) for side in (6.0, -6.0))
    return [(round(u, 2), round(v, 2)) for u, v in [*below, *above[::-1]]]


def place_on_it(share: float) -> tuple[float, float]:
    """A pixel on the middle of the strip that is bent up, from its clamp (0) to its tip (1)."""
    u, v = _places(np.array([share * STRIP.free_length_m]))[0]
    return (round(float(u), 1), round(float(v), 1))


def _places(s_m: np.ndarray) -> np.ndarray:
    k = BENT_UP.curvature_per_m or 1.0
    xy = np.column_stack([np.sin(k * s_m) / k, (1 - np.cos(k * s_m)) / k])
    return BENT_UP.optics.world_to_pixel(xy)


def side_by_side() -> np.ndarray:
    """Two strips, the second one 200 columns to the right of the first."""
    return np.hstack([BENT_UP.image, bright_down()])


def write(folder: Path, image: np.ndarray, name: str = "photo", **optics: object) -> Path:
    """A photograph with optics.json and sheet.toml beside it."""
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}.png"
    cv2.imwrite(str(path), image)
    known = json.loads(BENT_UP.optics.to_json()) | {"image_size": None} | optics
    known = {key: value for key, value in known.items() if value is not None}
    (folder / "optics.json").write_text(json.dumps(known))
    mm = {"free_length_mm": STRIP.free_length_m, "thickness_mm": STRIP.thickness_m}
    lines = [f"{key} = {1e3 * value:g}" for key, value in mm.items()]
    (folder / "sheet.toml").write_text("\n".join(lines) + "\n")
    return path


def off_px(points_px: object, example: Example, shift_px: float = 0.0) -> float:
    """RMS distance of a curve's points from the strip that was drawn, pixels."""
    places = np.asarray(points_px, dtype=float) - (shift_px, 0.0)
    x_m, y_m = example.optics.pixel_to_world(places).T
    away = example.distances_m(x_m, y_m) * example.optics.px_per_m
    return float(np.sqrt(np.mean(away**2)))
