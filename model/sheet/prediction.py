"""What a `SheetModel` says of a condition: reachable or why not, force, contact, shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypedDict

import numpy as np

from model.measurements import (
    Displayed,
    FloatArray,
    Summary,
    dataframe,
    in_decimals,
    in_volts,
)
from model.mechanics.contact_range import limit_m, other_solutions, stable
from model.mechanics.equilibrium import Equilibria
from model.sheet.beam_problem import ActiveEffect, ConditionProblem
from model.sheet.solution import SolvedProblems, sampled_s, solved

if TYPE_CHECKING:
    import pandas as pd


class Predictable(Protocol):
    """What is predicted from: a `SheetModel`."""

    @property
    def effects(self) -> tuple[ActiveEffect, ...]:
        """The effects that are in it."""

    def alternating_voltages_V(self, configuration: str, voltage_V: float) -> tuple[float, ...]:
        """Return the voltage, and those that it takes turns with in a run."""

    def beyond(self, configuration: str, position_m: float) -> str:
        """Return a remark on a position that lies outside those fitted; else nothing."""

    def setups(
        self, configuration: str, places: Sequence[tuple[float | None, float]]
    ) -> list[ConditionProblem]:
        """Return the beam problems of positions and voltages, effects included."""


class _Asked(TypedDict):
    """The condition that was asked for."""

    configuration: str
    position_m: float
    voltage_V: float


@dataclass(frozen=True, kw_only=True, repr=False)
class Prediction(Displayed):
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

    def summary(self) -> Summary:
        """Return force, contact and remark."""
        where = f"{self.configuration}, {1e3 * self.position_m:g} mm, {in_volts(self.voltage_V)}"
        if not self.reachable:
            return Summary(f"Prediction {where}: {self.why}")
        rows = [
            ("force F along the arc", in_decimals(1e3 * self.F_N, 4), "mN"),
            ("force N normal to the sheet", in_decimals(1e3 * self.N_N, 4), "mN"),
            ("contact along the sheet", f"{1e3 * self.s_hat_m:.3f}", "mm"),
            ("direction of the sheet there", f"{np.degrees(self.phi_hat_rad):.3f}", "degrees"),
            ("points of the shape", f"{len(self.s_m)}", ""),
        ]
        notes = (self.why,) if self.why else ()
        return Summary(f"Prediction {where}", ("quantity", "value", "unit"), rows, notes)

    def to_dataframe(self) -> pd.DataFrame:
        """Return the shape as a pandas data frame, a row for each point, in SI units."""
        return dataframe({
            "s_m": self.s_m, "x_m": self.x_m, "y_m": self.y_m,
            "curvature_per_m": self.curvature_per_m,
        })  # fmt: skip

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


def predict(
    model: Predictable,
    configuration: str,
    position_m: float,
    voltage_V: float,
    *,
    as_seen: bool = True,
) -> Prediction:
    """Predict a condition's force and shape on the branch that continues the free shape.

    With `as_seen` these are the readings of load cell and camera, where the model has effects of
    the instruments; otherwise the sheet's own force and shape.
    """
    volts = (
        model.alternating_voltages_V(configuration, voltage_V) if model.effects else (voltage_V,)
    )
    found = solved(model.setups(configuration, [(position_m, v) for v in volts]))
    setup = found.setups[0]
    beyond = filter(None, [model.beyond(configuration, position_m)])
    asked = _Asked(configuration=configuration, position_m=position_m, voltage_V=voltage_V)
    if not found.reachable[0]:
        nothing = np.zeros(0)
        gone = np.nan
        return Prediction(
            **asked, reachable=False, why="not reachable: " + _why_not(setup, _first(found)),
            F_N=gone, N_N=gone, s_hat_m=gone, phi_hat_rad=gone,
            s_m=nothing, x_m=nothing, y_m=nothing, curvature_per_m=nothing,
        )  # fmt: skip
    s, F = sampled_s(setup), float(found.force_N[0])
    x, y, curvature = _shape(model, found, s, position_m, as_seen=as_seen)
    if model.effects and as_seen:
        from model.sheet.instruments import load_cell_N

        places = {v: k for k, v in enumerate(volts)}
        F += load_cell_N(model.effects, found, [position_m] * len(volts), places, voltage_V)
    return Prediction(
        **asked,
        reachable=True,
        why="; ".join([*_remarks(_first(found), setup), *beyond]),
        F_N=F,
        N_N=float(found.normal_N[0]),
        s_hat_m=float(found.s_hat_m[0]),
        phi_hat_rad=float(found.phi_hat_rad[0]),
        s_m=s,
        x_m=x,
        y_m=y,
        curvature_per_m=curvature,
    )


def predict_free(
    model: Predictable, configuration: str, voltage_V: float, *, as_seen: bool = True
) -> tuple[FloatArray, ...]:
    """s, x, y of the sheet with nothing touching it."""
    found = solved(model.setups(configuration, [(None, voltage_V)]))
    s = sampled_s(found.setups[0])
    x, y, _ = _shape(model, found, s, None, as_seen=as_seen)
    return s, x, y


def _shape(
    model: Predictable,
    found: SolvedProblems,
    s_m: FloatArray,
    position_m: float | None,
    *,
    as_seen: bool,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """x, y and curvature of the first of the solutions."""
    if not (model.effects and as_seen):
        one = found.shapes(s_m)
        return one.x_m[0], one.y_m[0], one.curvature_per_m[0]
    from model.sheet.instruments import as_imaged, camera_m

    setup = found.setups[0]
    then = as_imaged(setup, model.effects, position_m)
    seen = found if then is setup else solved([then])
    one = seen.shapes(s_m)
    x, y = one.x_m[0], one.y_m[0]
    dx, dy = camera_m(model.effects, seen, one)
    return x + dx, y + dy, one.curvature_per_m[0]


def _first(found: SolvedProblems) -> Equilibria:
    """Return the equilibrium of the first setup, which may lie in a batch with others."""
    return next(part for rows, part in found.parts if rows[0] == 0)


def _why_not(setup: ConditionProblem, found: Equilibria) -> str:
    limit, slips = limit_m(found.problems)
    if not np.isfinite(limit):
        sheet = setup.sheet
        whole_m = sheet.free_length_m + sheet.elongation_m
        if whole_m < sheet.arc_radius_m:
            return (
                f"the sheet does not reach the arc: {1e3 * whole_m:g} mm with its elongation, the"
                f" arc's radius is {1e3 * sheet.arc_radius_m:g} mm"
            )
        return "no position of this sheet on the arc is an equilibrium"
    origin = setup.sheet.arc_origin_rad - setup.clamp_rad
    at = limit - origin * setup.sheet.arc_radius_m
    if slips:
        return f"the sheet slips out at {at * 1e3:.1f} mm"
    return f"there is no equilibrium beyond {at * 1e3:.1f} mm"


def _remarks(found: Equilibria, setup: ConditionProblem) -> list[str]:
    remarks = []
    if not stable(found):
        remarks.append("not stable: the sheet would jump away from this shape")
    others = other_solutions(found)
    if others:
        forces = ", ".join(f"{in_decimals(setup.B_Nm2 * nu * 1e3, 2)} mN" for nu in others)
        remarks.append(f"more than one solution: also with N = {forces}")
    return remarks
