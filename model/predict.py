"""What a `SheetModel` says of a condition: reachable or why not, force, contact, shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from model.beam import Equilibria, Problems, Status, problems, solve
from model.field import Field, merged_breaks
from model.free import free_shape
from model.measurements import FloatArray
from model.reach import limit_m, other_solutions, stable
from model.setup import Setup
from model.sheet_model import SheetModel

SPACING_M = 0.5e-3


@dataclass(frozen=True)
class Prediction:
    """One condition; where it is not reachable the numbers are NaN and the shape is empty."""

    configuration: str
    position_m: float
    voltage_V: float
    reachable: bool
    why: str  # what is wrong or remarkable; empty when nothing is
    F_N: float
    N_N: float
    s_hat_m: float
    phi_hat_rad: float
    s_m: FloatArray
    x_m: FloatArray
    y_m: FloatArray
    curvature_per_m: FloatArray

    def to_json(self) -> dict[str, Any]:
        """For `simulate --json`; numbers that do not exist are null."""

        def number(value: float) -> float | None:
            return float(value) if np.isfinite(value) else None

        return {
            "configuration": self.configuration,
            "position_mm": round(self.position_m * 1e3, 12),
            "voltage_V": self.voltage_V,
            "reachable": self.reachable,
            "why": self.why,
            "F_N": number(self.F_N),
            "N_N": number(self.N_N),
            "s_hat_mm": number(self.s_hat_m * 1e3),
            "phi_hat_rad": number(self.phi_hat_rad),
            "x_mm": (self.x_m * 1e3).tolist(),
            "y_mm": (self.y_m * 1e3).tolist(),
            "curvature_per_m": self.curvature_per_m.tolist(),
        }


def free_curvature(setup: Setup) -> Field:
    """k* = k0 + Me/B(s)."""
    if setup.softness is None:
        return setup.rest + setup.eibm * (1.0 / setup.B_Nm2)
    soft, eibm, rest = setup.softness, setup.eibm, setup.rest
    kinks = merged_breaks([soft.breaks_m, eibm.breaks_m, rest.breaks_m])

    def value(s: FloatArray) -> FloatArray:
        return rest(s) + eibm(s) * soft(s) / setup.B_Nm2

    return Field.smooth(value, rest.length_m, kinks)


def batch(setups: list[Setup]) -> Problems:
    """The beam problems of setups of one sheet."""
    sheet = setups[0].sheet
    angles = [s.angle_rad - s.clamp_rad for s in setups]
    return problems(
        [free_curvature(s) for s in setups], angles, sheet.arc_radius_m, sheet.elongation_m,
        setups[0].softness,
    )  # fmt: skip


def sampled_s(setup: Setup) -> FloatArray:
    """Points from the clamp to the visible end, the sheet's end among them."""
    length, end = setup.sheet.free_length_m, setup.sheet.free_length_m + setup.sheet.elongation_m
    inner = np.linspace(0.0, length, max(2, int(np.ceil(length / SPACING_M - 1e-9)) + 1))
    outer = np.linspace(length, end, int(np.ceil((end - length) / SPACING_M - 1e-9)) + 1)[1:]
    return np.concatenate([inner, outer])


def predict(
    model: SheetModel, configuration: str, position_m: float, voltage_V: float
) -> Prediction:
    """The condition's force and shape on the branch that continues the free shape."""
    setup = model.setup(configuration, position_m, voltage_V)
    found = solve(batch([setup]))
    names = (configuration, position_m, voltage_V)
    if found.status[0] != Status.SOLVED:
        nothing = np.zeros(0)
        why = "not reachable: " + _why_not(setup, found)
        gone = np.nan
        return Prediction(
            *names, reachable=False, why=why, F_N=gone, N_N=gone, s_hat_m=gone, phi_hat_rad=gone,
            s_m=nothing, x_m=nothing, y_m=nothing, curvature_per_m=nothing,
        )  # fmt: skip
    s = sampled_s(setup)
    shape = found.shapes(s)
    cos, sin = np.cos(setup.clamp_rad), np.sin(setup.clamp_rad)
    x, y = shape.x_m[0], shape.y_m[0]
    why = "; ".join(_remarks(found, setup))
    return Prediction(
        *names,
        reachable=True,
        why=why,
        F_N=float(found.force(setup.B_Nm2)[0]),
        N_N=float(setup.B_Nm2 * found.nu[0]),
        s_hat_m=float(found.s_hat_m[0]),
        phi_hat_rad=float(found.phi_hat_rad[0] + setup.clamp_rad),
        s_m=s,
        x_m=cos * x - sin * y,
        y_m=sin * x + cos * y,
        curvature_per_m=shape.curvature_per_m[0],
    )


def predict_free(model: SheetModel, configuration: str, voltage_V: float) -> tuple[FloatArray, ...]:
    """s, x, y of the sheet with nothing touching it."""
    setup = model.setup(configuration, 0.0, voltage_V)
    s = sampled_s(setup)
    x, y, _, _ = free_shape(free_curvature(setup), s)
    cos, sin = np.cos(setup.clamp_rad), np.sin(setup.clamp_rad)
    return s, cos * x - sin * y, sin * x + cos * y


def _why_not(setup: Setup, found: Equilibria) -> str:
    limit, slips = limit_m(found.problems)
    if not np.isfinite(limit):
        return "no position of this sheet on the arc is an equilibrium"
    origin = setup.sheet.arc_origin_rad - setup.clamp_rad
    at = limit - origin * setup.sheet.arc_radius_m
    if slips:
        return f"the sheet slips out at {at * 1e3:.1f} mm"
    return f"there is no equilibrium beyond {at * 1e3:.1f} mm"


def _remarks(found: Equilibria, setup: Setup) -> list[str]:
    remarks = []
    if not stable(found):
        remarks.append("not stable: the sheet would jump away from this shape")
    others = other_solutions(found)
    if others:
        forces = ", ".join(f"{setup.B_Nm2 * nu * 1e3:.2f} mN" for nu in others)
        remarks.append(f"more than one solution: also with N = {forces}")
    return remarks
