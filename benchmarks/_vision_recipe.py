"""What a drawn picture of a sheet holds, given or at random."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


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
    swing_px: float = 0.0  # how far the tip swings to each side while the frames are averaged
    sheet: bool = True
    clutter: int = 0
    bits: int = 8
    place: tuple[float, float] | None = None
    physical: bool = False  # curvature as the gel's model has it, not at random
    extra: dict = field(default_factory=dict)


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
