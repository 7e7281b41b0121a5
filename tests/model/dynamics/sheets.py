"""Sheets at rest for tests of linear models: the long and the short one of the examples."""

from __future__ import annotations

from typing import Any

import numpy as np

from model.dynamics import (
    VACUUM,
    ContactSetup,
    DynamicBeam,
    ElectrodeLine,
    Elongation,
    FluidLoad,
    HeldVoltage,
    Resolution,
    Simulation,
    Viscoelasticity,
)
from model.dynamics.linear.linear_model import linear_model
from model.dynamics.linear.state_space import LinearSystem
from model.dynamics.linearised import SmallMotion, linearise
from model.mechanics.field import Field
from tests.model.dynamics.cases import AIR
from tests.model.dynamics.closed_form import StraightSheet

B, LENGTH_M, RADIUS_M = 1.27e-6, 0.05, 0.04
MATERIAL = Viscoelasticity(B_Nm2=B, shares=(0.15, 0.10), times_s=(0.02, 0.3), viscous_time_s=2e-4)
LINE = ElectrodeLine(
    electrode_ohm_per_m=4000.0,
    capacitance_F_per_m=0.3,
    bulk_ohm_m=0.5,
    leak_S_per_m=0.1,
    source_ohm=1.0,
)
STRAIGHT_SHEET = StraightSheet(
    length_m=LENGTH_M,
    mass_per_length_kg_per_m=5.775e-3,
    moment_per_volt_Nm=30 * B,
    material=MATERIAL,
    line=LINE,
)
FINE = Resolution(degrees=(12, 5), free_degrees=14)
AT_REST = HeldVoltage(np.zeros(1), np.zeros(1))


def beam(k0_per_m: float = 24.0, fluid: FluidLoad = AIR, **other: Any) -> DynamicBeam:
    """The long sheet of the examples; `k0_per_m` at the clamp."""
    length_m = other.get("length_m", LENGTH_M)
    given: dict[str, Any] = {
        "length_m": length_m,
        "mass_per_length_kg_per_m": 5.775e-3,
        "material": MATERIAL,
        "rest": Field.smooth(lambda s: k0_per_m * np.exp(-s / 0.04), length_m),
        "fluid": fluid,
        "electrodes": LINE,
        "moment_per_volt_Nm": (30 * B, 30 * B),
    }
    return DynamicBeam(**(given | other))


SHORT = {
    "length_m": 0.0045,
    "elongation": Elongation(length_m=0.04, mass_per_length_kg_per_m=4e-3),
}


def at_rest(
    sheet: DynamicBeam, position_m: float | None, resolution: Resolution = FINE
) -> SmallMotion:
    """Small motions of a sheet at rest at 0 V: on its rolls, or free without a position."""
    setup = None if position_m is None else ContactSetup(radius_m=RADIUS_M, position_m=position_m)
    return linearise(Simulation(sheet, setup, AT_REST, resolution=resolution))


def model_of(
    sheet: DynamicBeam, position_m: float | None, resolution: Resolution = FINE
) -> LinearSystem:
    """Its linear model."""
    return linear_model(at_rest(sheet, position_m, resolution))


def straight(position_m: float | None, resolution: Resolution = FINE) -> LinearSystem:
    """The linear model of the straight sheet in vacuum, as the closed form has it."""
    return model_of(beam(0.0, VACUUM), position_m, resolution)
