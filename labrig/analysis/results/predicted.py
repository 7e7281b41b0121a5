"""What models predict at the conditions of a session, with the 90 % band of their parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import stdtrit

from labrig.analysis.results.measured import in_mm, known, plain_curve, rounded
from labrig.analysis.results.models import CandidateModel
from model import Condition, Measurements, ModelError, SheetModel, predict, predict_free
from model.measurements import FloatArray

BEYOND_M = 1e-3  # lines go on beyond the outer positions
STEP_M = 1e-3


@dataclass(frozen=True)
class Predicted:
    """What one model predicts, as plain data."""

    conditions: dict[int, dict[str, Any]]  # by the condition's place among the measurements'
    lines: dict[str, list[dict[str, Any]]]  # by configuration


@dataclass(frozen=True, kw_only=True)
class _Answer:
    """Force and shape of one condition; NaN and empty where there is no equilibrium."""

    force_N: float
    x_m: FloatArray = field(default_factory=lambda: np.zeros(0))
    y_m: FloatArray = field(default_factory=lambda: np.zeros(0))
    why: str = ""


def predicted_by(model: CandidateModel, measurements: Measurements) -> Predicted:
    """Return a model's force and shape of each condition that it knows, and its lines F(p)."""
    conditions: dict[int, dict[str, Any]] = {}
    half90_N: dict[tuple[str, float], dict[float, float]] = {}
    made: dict[tuple[str, float | None, float], dict[str, Any]] = {}
    for i, condition in enumerate(measurements.conditions):
        if not _knows(model.model, condition):
            continue
        key = (condition.configuration, condition.position_m, condition.voltage_V)
        if key not in made:
            made[key], half_N = _with_band(model, condition)
            if condition.position_m is not None and np.isfinite(half_N):
                half90_N.setdefault(key[::2], {})[condition.position_m] = half_N
        conditions[i] = made[key]
    lines: dict[str, list[dict[str, Any]]] = {}
    for (name, voltage_V), halves in half90_N.items():
        lines.setdefault(name, []).append(_line(model, name, voltage_V, halves))
    return Predicted(conditions, lines)


def _knows(model: SheetModel, condition: Condition) -> bool:
    """Whether the model says anything of a condition."""
    sheet = model.sheets.get(condition.configuration)
    if sheet is None:
        return False
    volts = [0.0, *sheet.eibm]
    return min(volts) <= condition.voltage_V <= max(volts)


def _with_band(model: CandidateModel, condition: Condition) -> tuple[dict[str, Any], float]:
    """Return the prediction of a condition as plain data, and the half width of its force's band."""
    name = condition.configuration
    best = _answer(model.model, condition)
    others = [_answer(one, condition) for one in model.displaced[name]]
    reach = float(stdtrit(model.model.sheets[name].B.freedom, 0.95))
    half_N = reach * _in_squares([one.force_N - best.force_N for one in others])
    force_mN = known(1e3 * best.force_N)
    plain = {
        "force_mN": force_mN,
        "force90_mN": None
        if force_mN is None
        else [force_mN - 1e3 * half_N, force_mN + 1e3 * half_N],
        "curve": None,
        "why": best.why,
    }
    if len(best.x_m):
        beside = [_off(best, one) for one in others if len(one.x_m) == len(best.x_m)]
        half_m = reach * np.sqrt(np.sum(np.square(beside), axis=0)) if beside else None
        plain["curve"] = plain_curve(best.x_m, best.y_m, half_m)
    return plain, half_N


def _answer(model: SheetModel, condition: Condition) -> _Answer:
    name, voltage_V = condition.configuration, condition.voltage_V
    try:
        if condition.position_m is None:
            _, x, y = predict_free(model, name, voltage_V)
            return _Answer(force_N=np.nan, x_m=x, y_m=y)
        found = predict(model, name, condition.position_m, voltage_V)
    except ModelError as error:
        return _Answer(force_N=np.nan, why=str(error))
    return _Answer(force_N=found.F_N, x_m=found.x_m, y_m=found.y_m, why=found.why)


def _in_squares(differences: Sequence[float]) -> float:
    """Return the root of the summed squares of those that are known."""
    values = np.array([one for one in differences if np.isfinite(one)])
    return float(np.sqrt(np.sum(values**2)))


def _off(best: _Answer, other: _Answer) -> FloatArray:
    """Return by how much a shape lies beside another, along the normal, m."""
    tx, ty = np.gradient(best.x_m), np.gradient(best.y_m)
    size = np.hypot(tx, ty)
    return np.asarray(
        (-ty * (other.x_m - best.x_m) + tx * (other.y_m - best.y_m)) / size, dtype=float
    )


def _line(
    model: CandidateModel, name: str, voltage_V: float, halves: dict[float, float]
) -> dict[str, Any]:
    """Return F(p) of a voltage; its band is that of the positions measured, straight between."""
    places = np.array(sorted(halves))
    low, high = places[0] - BEYOND_M, places[-1] + BEYOND_M
    p = np.union1d(np.linspace(low, high, max(2, round((high - low) / STEP_M) + 1)), places)
    force_N = np.array([_force_N(model.model, name, float(one), voltage_V) for one in p])
    half_N = np.interp(p, places, [halves[one] for one in places.tolist()])
    return {
        "model": model.id,
        "voltage_V": voltage_V,
        "p_mm": [in_mm(float(one)) for one in p],
        "F_mN": rounded(1e3 * force_N),
        "half90_mN": rounded(1e3 * half_N),
    }


def _force_N(model: SheetModel, name: str, position_m: float, voltage_V: float) -> float:
    try:
        return predict(model, name, position_m, voltage_V).F_N
    except ModelError:
        return float("nan")
