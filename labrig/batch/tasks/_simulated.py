"""Sessions drawn from a model, with noise: what a quiet rig would measure of such sheets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model import Condition, Curve, Measurements, ModelError, Reading, SheetModel, predict


@dataclass(frozen=True, kw_only=True)
class Simulated:
    """What is measured, and how well."""

    positions_m: tuple[float, ...]
    readings: int = 4  # of each voltage at each position
    force_noise_N: float = 2e-5  # of a reading
    curve_noise_m: float = 2e-6  # of each point of a curve, across it
    seed: int = 0


def simulated(model: SheetModel, wanted: Simulated) -> Measurements:
    """Return measurements at these positions, at 0 V and each voltage of the model.

    Positions that the sheet does not reach are left out. Raises ModelError where that leaves none.
    """
    dice = np.random.default_rng(wanted.seed)
    conditions = [
        condition
        for name, one in model.sheets.items()
        for place_m in wanted.positions_m
        for volts in (0.0, *sorted(one.eibm))
        if (condition := _condition(model, name, (place_m, volts), wanted, dice)) is not None
    ]
    if not conditions:
        raise ModelError("the sheet reaches none of the positions")
    sheets = {name: one.sheet for name, one in model.sheets.items()}
    return Measurements(sheets=sheets, conditions=tuple(conditions), source="simulated")


def _condition(
    model: SheetModel,
    name: str,
    at: tuple[float, float],
    wanted: Simulated,
    dice: np.random.Generator,
) -> Condition | None:
    place_m, volts = at
    found = predict(model, name, place_m, volts)
    if not found.reachable:
        return None
    forces = found.F_N + dice.normal(0.0, wanted.force_noise_N, wanted.readings)
    n = len(found.s_m)
    # Across the sheet: along it nobody sees an error.
    across = dice.normal(0.0, wanted.curve_noise_m, n)
    dx, dy = np.gradient(found.x_m), np.gradient(found.y_m)
    length = np.hypot(dx, dy)
    curve = Curve(
        s_m=found.s_m,
        x_m=found.x_m - across * dy / length,
        y_m=found.y_m + across * dx / length,
        sigma_m=np.full(n, wanted.curve_noise_m),
    )
    return Condition(
        configuration=name,
        position_m=place_m,
        voltage_V=volts,
        readings=tuple(
            Reading(index=i, kind="kept" if volts else "zero", force_N=float(force))
            for i, force in enumerate(forces)
        ),
        curve=curve,
    )
