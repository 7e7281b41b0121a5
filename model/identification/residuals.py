"""How far a model is from what was measured: Tables 5 and 6, figure 9."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from model.identification.observations import Observation, Observed
from model.measurements import Curve, FloatArray, rms
from model.mechanics.equilibrium import Shapes, SolverStatus
from model.mechanics.field import Field
from model.mechanics.free_shape import free_shape
from model.sheet.prediction import predict, predict_free
from model.sheet.sheet_model import SheetModel
from model.sheet.solution import free_curvature, sampled_s, solved

Kind = Literal["constant", "varying"]


@dataclass(frozen=True)
class Rmse:
    """Root mean squared errors; NaN where nothing was measured."""

    force_N: float
    curve_m: float


@dataclass(frozen=True, kw_only=True)
class ConditionResidual:
    """One condition against the models with constant and with varying EIBM."""

    name: str
    configuration: str
    position_m: float | None
    voltage_V: float
    force_N: float  # measured; NaN: not measured
    force_sigma_N: float  # of the mean, from the readings' scatter
    predicted_N: dict[Kind, float]
    curve_rmse_m: dict[Kind, float]  # of the sheet itself, not its elongation
    why: dict[Kind, str] = field(default_factory=dict)  # where a model has no answer


def residuals(
    observed: list[Observed], constant: SheetModel, varying: SheetModel
) -> tuple[ConditionResidual, ...]:
    """All conditions of all configurations."""
    rows = []
    for one in observed:
        answers: dict[Kind, list[_PredictedCondition]] = {
            "constant": against(one, constant), "varying": against(one, varying)
        }  # fmt: skip
        for i, o in enumerate(one.observations):
            sigma = np.sqrt(o.force_variance_N2 / o.readings) if o.readings else np.nan
            rows.append(
                ConditionResidual(
                    name=o.name,
                    configuration=o.configuration,
                    position_m=o.position_m,
                    voltage_V=o.voltage_V,
                    force_N=o.force_N,
                    force_sigma_N=float(sigma),
                    predicted_N={k: a[i].force_N for k, a in answers.items()},
                    curve_rmse_m={k: a[i].curve_m for k, a in answers.items()},
                    why={k: a[i].why for k, a in answers.items() if a[i].why},
                )
            )
    return tuple(rows)


@dataclass(frozen=True)
class _PredictedCondition:
    force_N: float
    curve_m: float
    why: str = ""


def against(observed: Observed, model: SheetModel) -> list[_PredictedCondition]:
    """Return a model's force and its distance from the measured curve, for each condition."""
    if model.effects:
        return [_seen(observed, o, model) for o in observed.observations]
    name, answers = observed.sheet.configuration, []
    setups = [model.setup(name, o.position_m or 0.0, o.voltage_V) for o in observed.observations]
    found = solved(setups)
    shapes = found.shapes(sampled_s(setups[0]))
    for i, o in enumerate(observed.observations):
        if o.position_m is None:
            answers.append(
                _PredictedCondition(np.nan, _free_distance(free_curvature(setups[i]), o))
            )
        elif found.status[i] != SolverStatus.SOLVED:
            answers.append(_PredictedCondition(np.nan, np.nan, "has no equilibrium"))
        else:
            force = float(found.force_N[i])
            answers.append(_PredictedCondition(force, _distance(shapes, i, o.curve, observed)))
    return answers


def _seen(observed: Observed, o: Observation, model: SheetModel) -> _PredictedCondition:
    """One condition against a model with effects, those of load cell and camera among them."""
    name, length = observed.sheet.configuration, observed.sheet.free_length_m
    if o.position_m is None:
        force, why = np.nan, ""
        s, x, y = predict_free(model, name, o.voltage_V)
    else:
        found = predict(model, name, o.position_m, o.voltage_V)
        if not found.reachable:
            return _PredictedCondition(np.nan, np.nan, "has no equilibrium")
        force, why, s, x, y = found.F_N, "", found.s_m, found.x_m, found.y_m
    inside = s <= length * (1.0 + 1e-9)
    off = np.nan if o.curve is None else distance_to(x[inside], y[inside], o.curve, length)
    return _PredictedCondition(force, off, why)


def _free_distance(kappa: Field, o: Observation) -> float:
    if o.curve is None:
        return np.nan
    s = np.linspace(0.0, kappa.length_m, 401)
    x, y, _ = free_shape(kappa, s)
    return distance_to(x, y, o.curve, kappa.length_m)


def _distance(shapes: Shapes, i: int, curve: Curve | None, observed: Observed) -> float:
    if curve is None:
        return np.nan
    inside = shapes.s_m <= observed.sheet.free_length_m * (1.0 + 1e-9)
    return distance_to(
        shapes.x_m[i, inside], shapes.y_m[i, inside], curve, observed.sheet.free_length_m
    )


def distance_to(x: FloatArray, y: FloatArray, curve: Curve, length_m: float) -> float:
    """RMS distance of the measured points of the sheet from a polyline."""
    use = curve.s_m <= length_m * (1.0 + 1e-9)
    px, py = curve.x_m[use, None], curve.y_m[use, None]
    dx, dy = np.diff(x), np.diff(y)
    t = ((px - x[:-1]) * dx + (py - y[:-1]) * dy) / (dx * dx + dy * dy)
    inner = np.clip(t, 0.0, 1.0)
    # beyond the predicted end the distance to its tangent counts, not to its last point
    inner[:, -1] = np.maximum(t[:, -1], 0.0)
    squared = (px - x[:-1] - inner * dx) ** 2 + (py - y[:-1] - inner * dy) ** 2
    return float(np.sqrt(np.mean(np.min(squared, axis=1))))


def rmse(rows: Iterable[ConditionResidual], kind: Kind) -> Rmse:
    """Over conditions; each curve counts the same."""
    rows = list(rows)
    force = np.array([r.force_N - r.predicted_N[kind] for r in rows])
    curve = np.array([r.curve_rmse_m[kind] for r in rows])
    return Rmse(rms(force), rms(curve))
