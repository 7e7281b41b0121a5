"""What models predict at the conditions of a session, with bands that hold 90 % of measurements.

A band is about what a new set-up would measure: the uncertainty of the parameters, the scatter from
one set-up to the next and the noise of a condition are added in squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from labrig.analysis.results.measured import NORMAL_90, in_mm, known, plain_curve, rounded
from labrig.analysis.results.models import CandidateModel
from model import Measurements, ModelError, SheetModel, predict, predict_free
from model.identification.set_up_scatter import ConditionScatter, Place
from model.measurements import FloatArray
from model.mechanics.equilibrium import SolverStatus
from model.sheet.solution import sampled_s, solved

BEYOND_M = 1e-3  # lines go on beyond the outer positions
STEP_M = 1e-3


@dataclass(frozen=True)
class Predicted:
    """What one model predicts, as plain data."""

    conditions: dict[int, dict[str, Any]]  # by the condition's place among the measurements'
    lines: dict[str, list[dict[str, Any]]]  # by configuration


@dataclass(frozen=True, kw_only=True)
class _PlacePrediction:
    """Force and shape at one place; NaN and empty where there is no equilibrium."""

    force_N: float
    x_m: FloatArray = field(default_factory=lambda: np.zeros(0))
    y_m: FloatArray = field(default_factory=lambda: np.zeros(0))
    why: str = ""


@dataclass(frozen=True)
class _Band:
    """Half widths of the central 90 %."""

    force_N: float  # NaN: there is no force
    along_normal_m: FloatArray | None


def predicted_by(model: CandidateModel, measurements: Measurements) -> Predicted:
    """Return a model's force and shape of each condition that it knows, and its lines F(p)."""
    conditions: dict[int, dict[str, Any]] = {}
    lines: dict[str, list[dict[str, Any]]] = {}
    for name in model.model.sheets:
        places = {
            i: (c.position_m, c.voltage_V)
            for i, c in enumerate(measurements.conditions)
            if c.configuration == name and _knows(model.model, name, c.voltage_V)
        }
        distinct = list(dict.fromkeys(places.values()))
        found = dict(zip(distinct, _with_bands(model, name, distinct), strict=True))
        conditions |= {i: _plain(*found[place]) for i, place in places.items()}
        lines[name] = _lines(model, name, {place: band for place, (_, band) in found.items()})
    return Predicted(conditions, lines)


def _knows(model: SheetModel, name: str, voltage_V: float) -> bool:
    """Whether the model says anything of a voltage."""
    volts = [0.0, *model.sheets[name].eibm]
    return min(volts) <= voltage_V <= max(volts)


def _with_bands(
    model: CandidateModel, name: str, places: Sequence[Place]
) -> list[tuple[_PlacePrediction, _Band]]:
    from scipy.special import stdtrit  # slow to import, and the panel imports this module

    best = _answers(model.model, name, places)
    others = [_answers(one, name, places) for one in model.displaced[name]]
    reach = float(stdtrit(model.model.sheets[name].B.freedom, 0.95))
    beside = list(zip(*others, strict=True)) or [()] * len(best)
    scatter = model.scatter.get(name, {})
    return [
        (one, _band(one, near, scatter.get(place), reach))
        for one, near, place in zip(best, beside, places, strict=True)
    ]


def _band(
    best: _PlacePrediction,
    displaced: Sequence[_PlacePrediction],
    scatter: ConditionScatter | None,
    reach: float,
) -> _Band:
    force = [reach * (one.force_N - best.force_N) for one in displaced]
    off = [reach * _off(best, one) for one in displaced if len(one.x_m) == len(best.x_m) > 0]
    if scatter is not None:
        force.append(NORMAL_90 * scatter.force_N)
    if scatter is not None and len(scatter.s_m) and off:
        along = np.hypot(np.diff(best.x_m), np.diff(best.y_m))
        s_m = np.concatenate([[0.0], np.cumsum(along)])
        off.append(NORMAL_90 * np.interp(s_m, scatter.s_m, scatter.curve_m))
    known = np.array([one for one in force if np.isfinite(one)])
    return _Band(
        float(np.sqrt(np.sum(known**2))) if np.isfinite(best.force_N) else np.nan,
        np.sqrt(np.sum(np.square(off), axis=0)) if off else None,
    )


def _off(best: _PlacePrediction, other: _PlacePrediction) -> FloatArray:
    """Return by how much a shape lies beside another, along the normal, m."""
    tx, ty = np.gradient(best.x_m), np.gradient(best.y_m)
    across = -ty * (other.x_m - best.x_m) + tx * (other.y_m - best.y_m)
    return np.asarray(across / np.hypot(tx, ty), dtype=float)


def _answers(model: SheetModel, name: str, places: Sequence[Place]) -> list[_PlacePrediction]:
    """Return the readings of load cell and camera that a model predicts."""
    if model.effects or not places:
        return [_answer(model, name, *place) for place in places]
    found = solved(model.setups(name, places))  # one batch: hundreds in the time of one `predict`
    shapes = found.shapes(sampled_s(found.setups[0]))
    return [
        _PlacePrediction(force_N=float(found.force_N[i]), x_m=shapes.x_m[i], y_m=shapes.y_m[i])
        if found.status[i] == SolverStatus.SOLVED
        else _answer(model, name, *place)
        for i, place in enumerate(places)
    ]


def _answer(
    model: SheetModel, name: str, position_m: float | None, voltage_V: float
) -> _PlacePrediction:
    try:
        if position_m is None:
            _, x, y = predict_free(model, name, voltage_V)
            return _PlacePrediction(force_N=np.nan, x_m=x, y_m=y)
        found = predict(model, name, position_m, voltage_V)
    except ModelError as error:
        return _PlacePrediction(force_N=np.nan, why=str(error))
    return _PlacePrediction(force_N=found.F_N, x_m=found.x_m, y_m=found.y_m, why=found.why)


def _plain(answer: _PlacePrediction, band: _Band) -> dict[str, Any]:
    force_mN, half_mN = known(1e3 * answer.force_N), 1e3 * band.force_N
    interval = None if force_mN is None else [force_mN - half_mN, force_mN + half_mN]
    curve = plain_curve(answer.x_m, answer.y_m, band.along_normal_m) if len(answer.x_m) else None
    return {"force_mN": force_mN, "force90_mN": interval, "curve": curve, "why": answer.why}


def _lines(model: CandidateModel, name: str, bands: dict[Place, _Band]) -> list[dict[str, Any]]:
    """Return F(p) of each voltage; the band is that of the positions measured, straight between."""
    found = []
    for voltage_V in sorted({volts for _, volts in bands}, reverse=True):
        half_N = {
            position_m: band.force_N
            for (position_m, volts), band in bands.items()
            if position_m is not None and volts == voltage_V and np.isfinite(band.force_N)
        }
        if half_N:
            found.append(_line(model, name, voltage_V, half_N))
    return found


def _line(
    model: CandidateModel, name: str, voltage_V: float, half_N: dict[float, float]
) -> dict[str, Any]:
    measured = np.array(sorted(half_N))
    low, high = measured[0] - BEYOND_M, measured[-1] + BEYOND_M
    p = np.union1d(np.linspace(low, high, round((high - low) / STEP_M) + 1), measured)
    answers = _answers(model.model, name, [(float(one), voltage_V) for one in p])
    band = np.interp(p, measured, [half_N[one] for one in measured.tolist()])
    return {
        "model": model.id,
        "voltage_V": voltage_V,
        "p_mm": [in_mm(float(one)) for one in p],
        "F_mN": rounded(1e3 * np.array([one.force_N for one in answers])),
        "half90_mN": rounded(1e3 * band),
    }
