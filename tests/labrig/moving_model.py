"""A model file's sheet in time, with the numbers of the exact tables of `tests/data/reference`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model import Along, ConfiguredSheet, Parameter, SheetGeometry, SheetModel
from model.dynamics import DynamicSheet

B = 1.27e-6
CURVATURE_PER_V_PER_M = 30.0  # Me/B per volt of the double layer
LOAD_CELL = {"resonance_hz": 100.0, "damping": 0.02}  # of the moving world
DYNAMIC = {
    "mass_per_length_kg_per_m": 5.775e-3,
    "viscous_time_s": 2e-4,
    "electrode_ohm_per_m": 4000.0,
    "capacitance_F_per_m": 0.3,
    "bulk_ohm_m": 0.5,
    "leak_S_per_m": 0.1,
    "source_ohm": 1.0,
    "prony": [{"share": 0.15, "time_s": 0.02}, {"share": 0.10, "time_s": 0.3}],
    "elongation_mass_kg_per_m": 4e-3,
}
# B in N m2, free length and elongation in m, k0 in 1/m at the clamp and where it falls to 1/e in m
SHEETS = {"long": (B, 0.05, 0.0, 24.0, 0.04), "short": (0.85e-6, 0.0045, 0.04, 28.0, np.inf)}


def model(
    dynamic: bool = True,
    *,
    names: Sequence[str] = ("long",),
    fluid: str = "air",
    points: int = 21,
    negative_ratio: float = 1.0,
    stiffness: float = 1.0,
    load_cell: bool = False,
) -> SheetModel:
    """`fluid` around the sheets of these names; `points` at which the file states the initial
    curvature; `negative_ratio` of the moment per volt at U < 0 over that at U > 0; `stiffness` over
    the true one, at the same moments; `load_cell`: with a resonance."""
    beside = {"load_cell": LOAD_CELL} if load_cell else {}
    found = {}
    for name in names:
        alpha = CURVATURE_PER_V_PER_M * SHEETS[name][0]
        moments = {"positive": alpha, "negative": alpha * negative_ratio}
        given = DYNAMIC | beside | {"fluid": fluid, "moment_per_volt_Nm": moments}
        found[name] = DynamicSheet.from_dict(given, "dynamic")
    sheets = {name: _at_rest(name, points, stiffness) for name in names}
    return SheetModel(sheets=sheets, dynamic=found if dynamic else {})


def _at_rest(name: str, points: int, stiffness: float) -> ConfiguredSheet:
    B_Nm2, length_m, elongation_m, k0_per_m, decay_m = SHEETS[name]
    s = np.linspace(0.0, length_m, points)
    geometry = SheetGeometry(
        configuration=name,
        free_length_m=length_m,
        width_m=11e-3,
        thickness_m=0.21e-3,
        elongation_m=elongation_m,
        arc_radius_m=0.04,
        arc_origin_rad=0.0,
        initial_curvature=None,
    )
    return ConfiguredSheet(
        sheet=geometry,
        B=Parameter(value=stiffness * B_Nm2, sigma=0.0, unit="N m^2"),
        rest=Along(s, k0_per_m * np.exp(-s / decay_m), np.zeros(points), "1/m"),
        eibm={},
    )
