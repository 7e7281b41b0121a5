"""The inferred form of an effect, or of something unknown, with its band."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.discrepancy.locations.slots import TIMES, BasisShape, force_range_N, shapes, unit_of
from model.discrepancy.search.form_share import form_share, steps_of
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.verdict.prediction_error import variance
from model.discrepancy.verdict.result import FormCurve, Unknown
from model.effects.interface import Location
from model.identification.data.data_vector import Index
from model.identification.likelihood.form_error import FORM, cosine, waves_along
from model.identification.likelihood.linearisation import with_columns
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.model_state import Perturbation
from model.measurements import FloatArray
from model.sheet.beam_problem import ActiveEffect, Coordinate, Profile, Under

POINTS = 51
# of a free form's shapes, as a model file has them
COORDINATES: dict[str, Coordinate] = {
    "s": "s", "place": "s", "position": "position", "force": "force", "time": "time",
}  # fmt: skip
UNDER: dict[str, Under] = {"voltage": "voltage", "polarity": "polarity"}  # by part
Key = tuple[str, str, str]  # configuration, part, along


def unknown_of(fitted: MixedModelFit, contender: RankedCandidate) -> Unknown:
    """A free form with its band, along the coordinate in which it says most."""
    location: Location = contender.score.candidate.location  # type: ignore[assignment]
    found = shapes(fitted, location, contender.score.candidate.part)
    columns = np.stack([s.rows for s in found], axis=1)
    linear = with_columns(fitted.problem.study, fitted.linear, columns, contender.score.scale**-2.0)
    known = fitted.solution if contender.solution is None else contender.solution
    solution = weigh(linear.data, known.log_sigma)
    n = len(found)
    beta, C = solution.beta[-n:], solution.covariance[-n:, -n:]
    if location == "camera" and contender.score.candidate.part != "age":
        return _seen_wrong(fitted, found, beta, C)
    key = _strongest(fitted, found, columns, beta)
    name, part, along = key
    waves = [s.wave if _key(s) == key else None for s in found]
    use = np.array([w is not None for w in waves])
    t = np.linspace(0.0, 1.0, POINTS)
    by = np.stack([w(t) for w in waves if w is not None], axis=1)
    unit, factor = unit_of(location, part)
    values = factor * by @ beta[use]
    band = factor * np.sqrt(np.maximum(np.einsum("ti,ij,tj->t", by, C[np.ix_(use, use)], by), 0.0))
    start, end, at_unit = _span(fitted, name, part, along)
    return Unknown(
        location, name, start + t * (end - start), values, band, unit, along,
        _depends(location, part, along), at_unit, UNDER.get(part, ""),
    )  # fmt: skip


def _strongest(
    fitted: MixedModelFit, found: list[BasisShape], columns: FloatArray, beta: FloatArray
) -> Key:
    """The part of which the waves explain most, of the configuration where they do."""
    noise = variance(fitted)

    def weight(key: Key) -> float:
        use = [_key(s) == key and s.wave is not None for s in found]
        return float(np.sum((columns[:, use] @ beta[use]) ** 2 / noise))

    return max({_key(s): None for s in found if s.wave}, key=weight)


def _key(shape: BasisShape) -> Key:
    return shape.configuration, shape.part, shape.along


def _seen_wrong(
    fitted: MixedModelFit, found: list[BasisShape], beta: FloatArray, C: FloatArray
) -> Unknown:
    """How far the camera puts a curve beside itself, on the condition where it does so most."""
    name = found[0].configuration
    scene = fitted.problem.study.scenes[fitted.problem.study.names.index(name)]
    moving = [i for i, s in enumerate(found) if s.points_m is not None]
    each = np.stack([s.points_m for s in found if s.points_m is not None], axis=2)  # (K, S, n)
    beta, C = beta[moving], C[np.ix_(moving, moving)]
    moved = each @ beta
    k = int(np.argmax(np.max(np.abs(moved), axis=1)))
    s, keep = np.unique(scene.curve_s[k], return_index=True)
    band = np.sqrt(np.maximum(np.einsum("sn,nm,sm->s", each[k], C, each[k]), 0.0))[keep]
    return Unknown(
        "camera", name, s * 1e3, moved[k][keep] * 1e3, band * 1e3, "mm", "s",
        _depends("camera", "place", "place"),
    )  # fmt: skip


def with_free_form(fitted: MixedModelFit, contender: RankedCandidate) -> MixedModelFit:
    """The model with a free form in it, as far as a straight line goes."""
    columns = contender.score.candidate.columns
    linear = with_columns(fitted.problem.study, fitted.linear, columns, contender.score.scale**-2.0)
    known = fitted.solution if contender.solution is None else contender.solution
    span = slice(fitted.linear.columns.shape[1], linear.columns.shape[1])
    return replace(
        fitted, linear=linear, solution=weigh(linear.data, known.log_sigma),
        spans=(*fitted.spans, span),
    )  # fmt: skip


def _span(fitted: MixedModelFit, name: str, part: str, along: str) -> tuple[float, float, str]:
    """The coordinate's beginning and end, and its unit."""
    scene = fitted.problem.study.scenes[fitted.problem.study.names.index(name)]
    if along == "position":
        every = np.concatenate([one.stated_m for one in fitted.problem.study.scenes])
        return 0.0, float(np.nanmax(every)) * 1e3, "mm"
    if along == "force":
        low, high = force_range_N(fitted.problem.study)
        return low * 1e3, high * 1e3, "mN"
    if along != "time":
        return 0.0, scene.length * 1e3, "mm"
    during, wave = part.rpartition(", ")[2], fitted.problem.study.wave
    if during == "period" and wave is not None:
        return 0.0, wave.period_s, f"s into the period of {wave.period_s:.3g} s"
    return 0.0, *TIMES.get(during, TIMES["session"])


def _depends(location: Location, part: str, along: str) -> str:
    said = {
        "rest_curvature": "the same at all voltages and positions",
        "eibm": "in proportion to the EIBM, so it changes sign with the voltage",
        "even_moment": "only under voltage, with the same sign at both polarities",
        "compliance": "in proportion to the moment, at all voltages",
        "position": "goes with the position on the arc",
        "load_cell": "in the force alone, not in the shapes",
        "camera": "in the pictures alone, not in the forces",
        "time": "goes with time",
    }[location]
    if along == "time":
        during = part.rpartition(", ")[2]
        return f"{said}, in the course of {'each' if during != 'session' else 'the'} {during}"
    said += ", a function of the force" if along == "force" else ""
    said += ", only under voltage" if part == "voltage" else ""
    return said + (", the other way at the other polarity" if part == "polarity" else "")


def unknown_effect(one: Unknown) -> ActiveEffect:
    """As an empirical term of the model."""
    along = COORDINATES[one.along]
    scale = 1.0 if along == "time" else 1e-3
    profile = Profile(
        along,
        tuple((one.s_mm * scale).tolist()), tuple(one.profile.tolist()), tuple(one.band.tolist()),
        one.unit, one.under,
    )  # fmt: skip
    lens = one.location == "camera" and along == "s"  # which sees all configurations
    names = () if lens else (one.configuration,)
    return ActiveEffect("unknown", profile=profile, location=one.location, configurations=names)


def form_of(fitted: MixedModelFit, index: int) -> tuple[float, FormCurve | None]:
    """How much of an effect is deviation from its form, and the form along the sheet."""
    one, span = fitted.found[index], fitted.spans[index]
    steps, share = steps_of(fitted, index), form_share(fitted, index)
    if not steps:
        return share, None
    # the waves along the sheet come first, behind what may differ between configurations
    first = span.start + len(one.parameters())
    first += len(fitted.problem.study.names) > 1 and not one.effect.by_configuration
    places = np.arange(first, min(first + one.effect.waves, span.stop))
    if one.effect.form_error_along[:1] != ("s",) or not len(places):
        return share, None
    return share, _form_curve(fitted, *steps[0], places)


def _form_curve(fitted: MixedModelFit, c: int, step: Perturbation, places: Index) -> FormCurve:
    """An effect along the sheet where it is largest, without and with its deviation."""
    scene, solution = fitted.problem.study.scenes[c], fitted.solution
    G = scene.count
    along = step.beam[:, :G] + step.beam[:, G : 2 * G]
    values = along[int(np.argmax(np.max(np.abs(along), axis=1)))]
    t = scene.s_m / scene.length
    waves = np.stack([FORM * share * cosine(j, t) for j, share in waves_along(len(places))], axis=1)
    C = solution.covariance[np.ix_(places, places)]
    factor = 1.0 + waves @ solution.beta[places]
    sigma = np.sqrt(np.einsum("ti,ij,tj->t", waves, C, waves))
    scale = np.max(np.abs(values)) or 1.0
    return FormCurve(
        "s", "mm", scene.s_m * 1e3, values / scale, values * factor / scale,
        np.abs(values) * sigma / scale, "what the effect adds, relative",
    )  # fmt: skip
