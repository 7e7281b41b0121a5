"""Noise and set-ups of the world `chain`: mains hum, wandering zero, knocks, curves off together.

Every stream of random numbers has a key of its own: what is hidden changes none of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from benchmarks.worlds.generators._chain_links import Floats
from benchmarks.worlds.generators._chain_plant import LONG, SHORT, STEP_S, Sheet

WHITE_N = 0.10e-3  # of a sample
WANDER_N, WANDER_S = 8e-6, 6.0
HUM_N, HUM_HZ = 0.06e-3, 49.98
KNOCKS_PER_S, KNOCK_N, KNOCK_S = 1 / 300.0, 0.25e-3, 0.12
POINT_M = 2.0e-6  # of each point of a mean image
TOGETHER_M, TOGETHER_S_M = 1.5e-6, 8e-3  # of all images of a condition, and how far along
IMAGES = 10
EIBM_SHARE, STIFFNESS_SHARE, PLACE_M = 0.01, 0.01, 0.05e-3
TAILS = 6.0  # degrees of freedom of the set-ups' scatter (Student)
_SHEET, _SETUP, _FORCE, _CURVE, _ORDER = range(0xC4A0, 0xC4A5)


@dataclass(frozen=True)
class SetUp:
    """One run's set-up, over the nominal one."""

    eibm: float = 1.0
    stiffness: float = 1.0
    place_m: float = 0.0


def sheets(seed: int) -> dict[str, Sheet]:
    """Return the two configurations of a seed."""
    r = np.random.default_rng((seed, _SHEET))
    curl = r.uniform(0.8, 1.15)
    long = Sheet(
        name=LONG, free_m=0.05, elongation_m=0.0, stiffness_Nm2=1.2e-6 * r.uniform(0.85, 1.2),
        driven_per_m=r.uniform(24.0, 34.0), negative=r.uniform(0.7, 0.95),
        nodes_m=np.array([0.0, 0.02, 0.05]), rest_per_m=np.round(curl * np.array([21.0, 14, 8]), 2),
    )  # fmt: skip
    short = Sheet(
        name=SHORT, free_m=0.0045, elongation_m=0.04, stiffness_Nm2=0.85e-6 * r.uniform(0.85, 1.2),
        driven_per_m=r.uniform(60.0, 85.0), negative=r.uniform(0.7, 0.95),
        nodes_m=np.array([0.0, 0.0045]), rest_per_m=np.round(np.full(2, r.uniform(22, 30)), 2),
    )  # fmt: skip
    return {LONG: long, SHORT: short}


def order(seed: int, count: int, sheet: str) -> list[int]:
    """Return a random order of the positions of a configuration."""
    return np.random.default_rng((seed, _ORDER, len(sheet))).permutation(count).tolist()


def set_up(seed: int, run: int) -> SetUp:
    """Return how a run was set up."""
    r = np.random.default_rng((seed, _SETUP, run))
    eibm, stiffness, place = r.standard_t(TAILS, 3) * np.sqrt((TAILS - 2.0) / TAILS)
    return SetUp(
        float(np.exp(EIBM_SHARE * eibm)), float(np.exp(STIFFNESS_SHARE * stiffness)),
        float(PLACE_M * place),
    )  # fmt: skip


def force_noise(seed: int, run: int, time_s: Floats) -> Floats:
    """Return what the cell shows beside its load, in N."""
    r, count = np.random.default_rng((seed, _FORCE, run)), len(time_s)
    kept = np.exp(-STEP_S / WANDER_S)
    push = WANDER_N * np.sqrt(1.0 - kept**2) * r.standard_normal(count)
    push[0] = WANDER_N * r.standard_normal()
    wander = lfilter([1.0], [1.0, -kept], push)
    hum = HUM_N * np.sin(2 * np.pi * HUM_HZ * time_s + r.uniform(0, 2 * np.pi))
    hits = np.where(r.random(count) < KNOCKS_PER_S * STEP_S, r.normal(0.0, KNOCK_N, count), 0.0)
    knocks = lfilter([1.0], [1.0, -np.exp(-STEP_S / KNOCK_S)], hits)
    return np.asarray(wander + hum + knocks + WHITE_N * r.standard_normal(count))


def curve_errors(seed: int, run: int, s_m: Floats, images: int) -> tuple[Floats, Floats, Floats]:
    """Return distances along the normal, in m.

    What all images of a voltage share (3, points), the rest of the three mean images, and of each
    single image (images, points).
    """
    r = np.random.default_rng((seed, _CURVE, run))
    kernel = np.exp(-np.abs(s_m[:, None] - s_m) / TOGETHER_S_M)
    factor = TOGETHER_M * np.linalg.cholesky(kernel)
    shared = r.standard_normal((3, len(s_m))) @ factor.T
    means = POINT_M * r.standard_normal((3, len(s_m)))
    return shared, means, POINT_M * np.sqrt(IMAGES) * r.standard_normal((images, len(s_m)))
