"""A model file's sheet in time, with the numbers of the exact tables of `tests/data/reference`."""

from __future__ import annotations

import numpy as np

from model import Along, ConfiguredSheet, Parameter, SheetGeometry, SheetModel
from model.dynamics import DynamicSheet

B = 1.27e-6
DYNAMIC = {
    "mass_per_length_kg_per_m": 5.775e-3,
    "viscous_time_s": 2e-4,
    "electrode_ohm_per_m": 4000.0,
    "capacitance_F_per_m": 0.3,
    "bulk_ohm_m": 0.5,
    "leak_S_per_m": 0.1,
    "source_ohm": 1.0,
    "prony": [{"share": 0.15, "time_s": 0.02}, {"share": 0.10, "time_s": 0.3}],
    "fluid": "air",
}


def model(
    dynamic: bool = True, *, fluid: str = "air", points: int = 21, negative_ratio: float = 1.0
) -> SheetModel:
    """`fluid` around it; `points` at which the file states the initial curvature; `negative_ratio`
    of the moment per volt at U < 0 over that at U > 0."""
    geometry = SheetGeometry(
        configuration="long",
        free_length_m=0.05,
        width_m=11e-3,
        thickness_m=0.21e-3,
        elongation_m=0.0,
        arc_radius_m=0.04,
        arc_origin_rad=0.0,
        initial_curvature=None,
    )
    s = np.linspace(0.0, 0.05, points)
    one = ConfiguredSheet(
        sheet=geometry,
        B=Parameter(value=B, sigma=0.0, unit="N m^2"),
        rest=Along(s, 24 * np.exp(-s / 0.04), np.zeros(points), "1/m"),
        eibm={},
    )
    alpha = {"positive": 30 * B, "negative": 30 * B * negative_ratio}
    given = DYNAMIC | {"fluid": fluid, "moment_per_volt_Nm": alpha}
    found = DynamicSheet.from_dict(given, "dynamic")
    return SheetModel(sheets={"long": one}, dynamic={"long": found} if dynamic else {})
