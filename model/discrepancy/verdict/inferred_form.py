"""The inferred form of an effect, or of something unknown, with its band."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from model.discrepancy.criticism.image_noise import aside, image_noise, of_images
from model.discrepancy.criticism.set_up_scatter import largest_offsets, of_set_ups
from model.discrepancy.search.form_share import form_share, steps_of
from model.discrepancy.search.nonparametric_terms import BasisShape, shapes
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.verdict.ordered_scatter import followed
from model.discrepancy.verdict.prediction_error import variance
from model.discrepancy.verdict.result import FormCurve, Unknown
from model.identification.data.data_vector import Index
from model.identification.likelihood.form_ways import FORM, cosine, waves_along
from model.identification.likelihood.linearisation import with_columns
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.random_effects import EACH, WANDER_S
from model.locations import location
from model.locations.basis import EACH_POLARITY, WHICH_WAY
from model.locations.quantities import Perturbation
from model.measurements import FloatArray
from model.sheet.beam_problem import Under

POINTS = 51
LOOK_AT_PICTURES = (
    "How one picture is off says nothing of the next one, so the model file does not have it. Look"
    " at the pictures with their curves: does each curve follow the sheet, does an elongation stay"
    " straight, do clamp and camera stand still?"
)
NOT_FORETOLD = (
    "How one set-up is off says nothing of the next one, so the model file does not have it."
)
WANDERS = "a force that wanders in the course of each run, "
ONE_SESSION = "It says nothing of another session or moment, so the model file does not have it."
REPEAT_SET_UPS = (
    "Repeat three positions: what comes back with the position, or with the time, is no chance."
)
ALONG = {  # coordinates that follow from the sheet's state
    "force": ", a function of the force",
    "curvature": ", by how far the sheet is bent",
}
OF_PARTS = {  # whose functions are of several coordinates, or of several voltages
    EACH_POLARITY: ", under voltage, and of its own at each polarity",
    WHICH_WAY: ", by how far the sheet is bent and which way",
}
OF_TIME = {  # else as the part says
    "curvature": "initial curvature", "place": "whole picture", "scale": "scale of the picture",
}  # fmt: skip
# configuration, part, along, to what it is added, under which voltages
Key = tuple[str, str, str, str, str]


def unknown_of(fitted: MixedModelFit, candidate: RankedCandidate) -> Unknown:
    """Return a nonparametric term with its credible band, along its strongest coordinate."""
    name = candidate.score.candidate.location
    if of_images(candidate):
        return _in_images(fitted, candidate)
    if of_set_ups(candidate):
        return _of_set_ups(fitted, candidate)
    found = shapes(fitted, name, candidate.score.candidate.part)
    advice = "" if foretells(fitted, candidate) else ONE_SESSION
    columns = np.stack([s.rows for s in found], axis=1)
    linear = with_columns(
        fitted.problem.forward, fitted.linear, columns, candidate.score.scale**-2.0
    )
    known = fitted.solution if candidate.solution is None else candidate.solution
    solution = weigh(linear.data, known.log_sigma)
    n = len(found)
    beta, C = solution.beta[-n:], solution.covariance[-n:, -n:]
    if any(s.points_m is not None for s in found):
        return replace(_seen_wrong(fitted, name, found, beta, C), advice=advice)
    key = _strongest(fitted, found, columns, beta)
    own = [s for s in found if _key(s) == key and s.function is not None]
    use = np.array([_key(s) == key and s.function is not None for s in found])
    t = np.linspace(0.0, 1.0, POINTS)
    by = np.stack([s.function(t) for s in own if s.function is not None], axis=1)
    band = np.sqrt(np.maximum(np.einsum("ti,ij,tj->t", by, C[np.ix_(use, use)], by), 0.0))
    start, end, at_unit = own[0].span
    configuration, part, along, _, under = key
    return Unknown(
        location=name, configuration=configuration, s_mm=start + t * (end - start),
        profile=by @ beta[use], band=band, unit=own[0].unit, along=along,
        depends=dependence(name, part, along, under_applied_voltages(fitted, under), own[0].shows),
        at_unit=at_unit, under=cast("Under", under), advice=advice,
    )  # fmt: skip


def foretells(fitted: MixedModelFit, candidate: RankedCandidate) -> bool:
    """Return whether a prediction can show a nonparametric term: else a model file has none of it.

    How one picture, one set-up, or the course of one session is off says nothing of another one.
    """
    if of_images(candidate) or of_set_ups(candidate):
        return False
    own = candidate.score.candidate
    return any(shape.terms for shape in shapes(fitted, own.location, own.part))


def under_applied_voltages(fitted: MixedModelFit, under: str) -> str:
    """Return under which voltages a term acts; of one polarity alone there is no other one."""
    volts = np.concatenate([one.voltage_V for one in fitted.problem.forward.configuration_models])
    both = bool(np.any(volts > 0.0) and np.any(volts < 0.0))
    return "voltage" if under == "polarity" and not both else under


def _in_images(fitted: MixedModelFit, candidate: RankedCandidate) -> Unknown:
    """Return how far a curve is off, in the picture where it is so most."""
    name, one = of_images(candidate), with_free_form(fitted, candidate)
    configuration_model = fitted.problem.forward.configuration_models[
        fitted.problem.forward.names.index(name)
    ]
    span, solution = one.spans[-1], one.solution
    found = aside(configuration_model, solution.beta[span], solution.covariance[span, span])
    where, times = candidate.score.candidate.location, image_noise(fitted)[name].times
    depends = (
        f"{dependence(where, '', 's', '')}; in each picture of '{name}' the curve is shifted and"
        f" turned by amounts of its own, with {times:.1f} times the usual standard deviation, and"
        f" most in that of {found.name}"
    )
    return Unknown(
        location=where, configuration=name, s_mm=1e3 * found.s_m, profile=1e3 * found.off_m,
        band=1e3 * found.sigma_m, unit="mm", along="s", depends=depends, advice=LOOK_AT_PICTURES,
    )  # fmt: skip


def _of_set_ups(fitted: MixedModelFit, candidate: RankedCandidate) -> Unknown:
    """Return how far set-ups are off, of the configuration where they are so most."""
    one, where = with_free_form(fitted, candidate), candidate.score.candidate.location
    span, solution = one.spans[-1], one.solution
    name = of_set_ups(candidate)
    found = largest_offsets(fitted, name, solution.beta[span], solution.covariance[span, span])
    each = "at each voltage of each set-up" if name in EACH else "in each set-up"
    what = WANDERS if name in WANDER_S else ""
    depends = f"{what}of its own {each}, with {found.times:.0f} times the usual standard deviation"
    order = followed(fitted, name)
    if order is not None:
        depends += f", and follows {order[0]} (correlation {order[1]:.2f})"
    return Unknown(
        location=where, configuration=found.configuration, s_mm=found.position_mm,
        profile=found.off, band=found.sigma, unit=found.unit, along="position", depends=depends,
        advice=NOT_FORETOLD if order else f"{NOT_FORETOLD} {REPEAT_SET_UPS}",
    )  # fmt: skip


def _strongest(
    fitted: MixedModelFit, found: list[BasisShape], columns: FloatArray, beta: FloatArray
) -> Key:
    """Return the part that the waves explain best, of the configuration where they do."""
    noise = variance(fitted)

    def weight(key: Key) -> float:
        use = [_key(s) == key and s.function is not None for s in found]
        return float(np.sum((columns[:, use] @ beta[use]) ** 2 / noise))

    return max({_key(s): None for s in found if s.function}, key=weight)


def _key(shape: BasisShape) -> Key:
    return shape.configuration, shape.part, shape.along, shape.adds, shape.under


def _seen_wrong(
    fitted: MixedModelFit,
    location_name: str,
    found: list[BasisShape],
    beta: FloatArray,
    C: FloatArray,
) -> Unknown:
    """Return how far the camera puts a curve off, for the condition where it does so most.

    What is not the rig's has shapes of each configuration: it is told of that which is moved most.
    """
    every = {s.configuration: _moved(found, s.configuration, beta) for s in found}
    name = max(every, key=lambda one: float(np.max(np.abs(every[one][1]), initial=0.0)))
    moving, moved = every[name]
    configuration_model = fitted.problem.forward.configuration_models[
        fitted.problem.forward.names.index(name)
    ]
    each = np.stack([np.asarray(found[i].points_m) for i in moving], axis=2)  # (K, S, n)
    C = C[np.ix_(moving, moving)]
    k = int(np.argmax(np.max(np.abs(moved), axis=1)))
    s, keep = np.unique(configuration_model.curve_s[k], return_index=True)
    band = np.sqrt(np.maximum(np.einsum("sn,nm,sm->s", each[k], C, each[k]), 0.0))[keep]
    return Unknown(
        location=location_name, configuration=name, s_mm=s * 1e3, profile=moved[k][keep] * 1e3,
        band=band * 1e3, unit="mm", along="s",
        depends=dependence(
            location_name, found[moving[0]].part, found[moving[0]].along,
            under_applied_voltages(fitted, found[moving[0]].under), found[moving[0]].shows,
        ),
    )  # fmt: skip


def _moved(
    found: list[BasisShape], configuration: str, beta: FloatArray
) -> tuple[list[int], FloatArray]:
    """Return which shapes move the curves of a configuration, and by how much in all: (K, S)."""
    own = [
        i for i, s in enumerate(found) if s.configuration == configuration and np.any(s.points_m)
    ]
    total = sum(beta[i] * np.asarray(found[i].points_m) for i in own)
    return own, np.atleast_2d(np.asarray(total, dtype=float))


def with_free_form(fitted: MixedModelFit, candidate: RankedCandidate) -> MixedModelFit:
    """Return the model with a free form in it, as far as a straight line goes."""
    columns = candidate.score.candidate.columns
    linear = with_columns(
        fitted.problem.forward, fitted.linear, columns, candidate.score.scale**-2.0
    )
    known = fitted.solution if candidate.solution is None else candidate.solution
    span = slice(fitted.linear.columns.shape[1], linear.columns.shape[1])
    return replace(
        fitted, linear=linear, solution=weigh(linear.data, known.log_sigma),
        spans=(*fitted.spans, span),
    )  # fmt: skip


def dependence(location_name: str, part: str, along: str, under: str, shows: str = "") -> str:
    """Return the coordinate a nonparametric term depends on, for messages."""
    depends = location(location_name).depends
    if shows:
        return depends + shows
    if along == "time":
        what, _, during = part.rpartition(", ")
        one = "each" if during != "session" else "the"
        depends += f", the {OF_TIME.get(what, what)} in the course of {one} {during}"
        return depends + (", the other way at the other polarity" if under == "polarity" else "")
    if under:
        depends = depends.removesuffix(", at all voltages")
    if part in OF_PARTS:
        return depends + OF_PARTS[part]
    depends += ALONG.get(along, "")
    depends += ", as a moment" if part == "moment" else ""
    depends += ", only under voltage" if under == "voltage" else ""
    return depends + (", the other way at the other polarity" if under == "polarity" else "")


def form_of(fitted: MixedModelFit, index: int) -> tuple[float, FormCurve | None]:
    """Return how much of an effect is deviation from its form, and the form along the sheet."""
    one, span = fitted.found[index], fitted.spans[index]
    steps, share = steps_of(fitted, index), form_share(fitted, index)
    if not steps:
        return share, None
    # the waves along the sheet come first, behind what may differ between configurations
    first = span.start + len(one.parameters())
    first += len(fitted.problem.forward.names) > 1 and not one.effect.by_configuration
    places = np.arange(first, min(first + one.effect.waves, span.stop))
    if one.effect.form_error_along[:1] != ("s",) or not len(places):
        return share, None
    return share, _form_curve(fitted, *steps[0], places)


def _form_curve(fitted: MixedModelFit, c: int, step: Perturbation, places: Index) -> FormCurve:
    """Return an effect along the sheet where it is largest, without and with its deviation."""
    configuration_model, solution = fitted.problem.forward.configuration_models[c], fitted.solution
    G = configuration_model.count
    along = step.beam[:, :G] + step.beam[:, G : 2 * G]
    values = along[int(np.argmax(np.max(np.abs(along), axis=1)))]
    t = configuration_model.s_m / configuration_model.length
    waves = np.stack([FORM * share * cosine(j, t) for j, share in waves_along(len(places))], axis=1)
    C = solution.covariance[np.ix_(places, places)]
    factor = 1.0 + waves @ solution.beta[places]
    sigma = np.sqrt(np.einsum("ti,ij,tj->t", waves, C, waves))
    scale = np.max(np.abs(values)) or 1.0
    return FormCurve(
        along="s", unit="mm", at=configuration_model.s_m * 1e3, catalogue=values / scale,
        inferred=values * factor / scale, band=np.abs(values) * sigma / scale,
        what="what the effect adds, relative",
    )  # fmt: skip
