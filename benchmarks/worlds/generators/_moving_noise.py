"""Sheets, set-ups and noise of the world `moving`; each random stream has a key of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.worlds.generators._moving_sheet import Floats, Strip

WHITE_N, HUM_N, HUM_HZ = 0.05e-3, 0.04e-3, 49.96
DRIFT_N, DRIFT_S = 12e-6, (3.0, 90.0)  # of the zero: waves between these periods
POINT_M, SHAKE_RAD = 2.5e-6, 3e-5  # of a point of one image; of one image about the clamp
SHARED_M, SHARED_S_M = 1.2e-6, 10e-3  # what all images of a voltage share, and how far along
EIBM, STIFFNESS, PLACE_M = 0.01, 0.01, 0.05e-3  # standard deviations from set-up to set-up
_SHEET, _SETUP, _FORCE, _IMAGE, _ORDER = range(0x30F1, 0x30F6)


@dataclass(frozen=True)
class SetUp:
    """One run's, over the nominal one."""

    eibm: float = 1.0
    stiffness: float = 1.0
    place_m: float = 0.0


def strips(seed: int) -> dict[str, Strip]:
    """Return the two configurations of a seed."""
    r = np.random.default_rng((seed, _SHEET))
    curl, flat = r.uniform(0.85, 1.15), r.uniform(20.0, 30.0)
    long = Strip(
        name="long", free_m=0.05, bar_m=0.0, stiffness_Nm2=1.25e-6 * r.uniform(0.85, 1.2),
        driven_per_m=r.uniform(24.0, 34.0), negative=r.uniform(0.7, 0.95),
        nodes_m=np.linspace(0.0, 0.05, 3), rest_per_m=np.round(curl * np.array([20.0, 13, 8]), 2),
    )  # fmt: skip
    short = Strip(
        name="short", free_m=0.0045, bar_m=0.04, stiffness_Nm2=0.85e-6 * r.uniform(0.85, 1.2),
        driven_per_m=r.uniform(60.0, 85.0), negative=r.uniform(0.7, 0.95),
        nodes_m=np.array([0.0, 0.0045]), rest_per_m=np.round(np.full(2, flat), 2),
    )  # fmt: skip
    return {"long": long, "short": short}


def order(seed: int, count: int, name: str) -> list[int]:
    """Return a random order of the positions of a configuration."""
    return np.random.default_rng((seed, _ORDER, len(name))).permutation(count).tolist()


def set_up(seed: int, run: int) -> SetUp:
    """Return how a run was set up: a triangular scatter."""
    eibm, stiffness, place = np.random.default_rng((seed, _SETUP, run)).triangular(-1, 0, 1, 3)
    wide = np.sqrt(6.0)  # a triangle's standard deviation is 1/sqrt(6) of its half width
    return SetUp(
        1.0 + EIBM * wide * eibm, 1.0 + STIFFNESS * wide * stiffness, PLACE_M * wide * place
    )


def force_noise(seed: int, run: int, time_s: Floats) -> Floats:
    """Return white noise, the mains and a zero that drifts, in N."""
    r = np.random.default_rng((seed, _FORCE, run))
    periods = np.exp(r.uniform(*np.log(DRIFT_S), 8))
    phases = r.uniform(0, 2 * np.pi, 9)
    waves = np.sin(2 * np.pi * time_s[:, None] / periods + phases[:8])
    hum = HUM_N * np.sin(2 * np.pi * HUM_HZ * time_s + phases[8])
    white = WHITE_N * r.standard_normal(len(time_s))
    return np.asarray(DRIFT_N / 2.0 * waves.sum(axis=1) + hum + white)


def image_errors(seed: int, run: int, s_m: Floats, images: int) -> tuple[Floats, Floats]:
    """Return distances along the normal, m: shared by a voltage (3, points), of each image."""
    r = np.random.default_rng((seed, _IMAGE, run))
    kernel = np.exp(-0.5 * ((s_m[:, None] - s_m) / SHARED_S_M) ** 2) + 1e-9 * np.eye(len(s_m))
    shared = SHARED_M * r.standard_normal((3, len(s_m))) @ np.linalg.cholesky(kernel).T
    shake = SHAKE_RAD * r.standard_normal((images, 1)) * s_m
    return shared, shake + POINT_M * r.standard_normal((images, len(s_m)))
