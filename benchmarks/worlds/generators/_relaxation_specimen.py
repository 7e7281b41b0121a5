"""The sheets of the world `relaxation`, and how its sessions are laid out."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._relaxation_strip import Array, Strip
from benchmarks.worlds.session.layout import Layout
from model.measurements import SheetGeometry

RADIUS_M, WIDTH_M, THICKNESS_M = 0.04, 0.011, 0.21e-3
_SHEET, _ORDER, _SETUP = 0x5E1A, 0x5E1B, 0x5E1C


def _logistic(random: np.random.Generator, count: int) -> Array:
    """Return numbers of unit variance, with heavier tails than a Gaussian's."""
    return np.asarray(random.logistic(0.0, np.sqrt(3.0) / np.pi, count))


LAYOUT = Layout(
    rise_s=0.035, series_s=0.05, run_s=95.0, wet_s=14.0, registration_m=5e-6, order_key=_ORDER,
    setup_key=_SETUP, drawn=_logistic, position_m=0.06e-3, eibm=0.012, stiffness=0.008,
)  # fmt: skip


def strips(seed: int) -> dict[str, Strip]:
    """Return the two configurations of a seed."""
    r = np.random.default_rng((seed, _SHEET))
    nodes = np.array([0.0, 0.010, 0.025, 0.050])
    curl = r.uniform(0.85, 1.15) * np.exp(-nodes / r.uniform(0.040, 0.060))
    long = Strip(
        name="long", length_m=0.05, elongation_m=0.0, radius_m=RADIUS_M,
        stiffness_Nm2=float(1.3e-6 * r.uniform(0.8, 1.2)), eibm_per_m=_driven(r, 22.0, 33.0),
        nodes_m=nodes, rest_per_m=np.round(24.0 * curl, 2),
    )  # fmt: skip
    root = r.uniform(25.0, 31.0)
    short = Strip(
        name="short", length_m=0.0045, elongation_m=0.04, radius_m=RADIUS_M,
        stiffness_Nm2=float(0.9e-6 * r.uniform(0.8, 1.2)), eibm_per_m=_driven(r, 55.0, 82.0),
        nodes_m=np.array([0.0, 0.0045]), rest_per_m=np.round(np.array([root, 0.93 * root]), 2),
    )  # fmt: skip
    return {"long": long, "short": short}


def _driven(r: np.random.Generator, low: float, high: float) -> tuple[float, float]:
    positive = float(r.uniform(low, high))
    return positive, float(positive * r.uniform(0.72, 0.98))


def geometry(name: str, strip: Strip) -> SheetGeometry:
    """Return what is stated of a configuration."""
    return SheetGeometry(
        configuration=name, free_length_m=strip.length_m, width_m=WIDTH_M,
        thickness_m=THICKNESS_M, elongation_m=strip.elongation_m, arc_radius_m=RADIUS_M,
        arc_origin_rad=0.0, initial_curvature=(strip.nodes_m, strip.rest_per_m),
        rise_time_s=LAYOUT.rise_s,
    )  # fmt: skip
