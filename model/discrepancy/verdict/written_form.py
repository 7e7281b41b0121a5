"""The model as it is written: inferred forms are part of it, and the fit is solved with them.

In the search the deviations of a form are linear. Strong ones bend the line; here they become
terms of the model, act through the hooks as in every prediction, and everything is fitted again
from there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import cast

import numpy as np

from model.discrepancy.search.cross_validation import position_groups, when_left_out
from model.discrepancy.search.form_share import in_time
from model.discrepancy.search.nonparametric_terms import BasisShape, shapes
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import FEWEST_POSITIONS, FORM_GAIN_CHI2
from model.discrepancy.verdict.prediction_error import cells, variance
from model.identification.likelihood.form_error import formed
from model.identification.likelihood.form_ways import sampled
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import with_only
from model.identification.likelihood.mixed_model_fit import MixedModelFit, fit_mixed_model
from model.identification.likelihood.model_state import FormWay, Found
from model.locations import location
from model.locations.contract import BasisTerm
from model.measurements import FloatArray, ModelError
from model.sheet.beam_problem import Adds, Coordinate, Profile, Under
from model.sheet.form import key_of
from model.sheet.free_effect import free_effect


def written(
    known: MixedModelFit, final: MixedModelFit, free: RankedCandidate | None
) -> Iterator[MixedModelFit]:
    """Yield fits with the forms in the model, and with what is unknown; the best first.

    `final` is `known` with the columns of the free form, if there is one. Inferred forms are in
    the first one only if left-out positions are predicted better with them: what they add at the
    times and places of the session may be anything elsewhere.
    """
    beta = final.solution.beta
    found = [
        one if one.given is not None
        else formed(known.problem.forward, known.linear, one, _of_form(beta, one, span))
        for one, span in zip(known.found, known.spans, strict=True)
    ]  # fmt: skip
    if free is not None:
        found.append(_unnamed(known, free, beta[final.spans[-1]]))
    if not any(one.ways for one in found):
        yield final
        return
    if free is None and not _asked_for(known):
        yield from _rigid(known, final)
    yield from _formed(known, final, found)
    yield from _rigid(known, final)
    yield known


def _formed(
    known: MixedModelFit, final: MixedModelFit, found: Sequence[Found]
) -> Iterator[MixedModelFit]:
    """Yield fits with the forms, begun from all of their deviations and from none."""
    beta, size = final.solution.beta, known.problem.bases.size
    for theta, share in ((final.theta + beta[:size], 1.0), (known.theta, 0.0)):
        some = tuple(_with_share(one, share) for one in found)
        with suppress(ModelError, np.linalg.LinAlgError):
            fitted = fit_mixed_model(known.problem, theta, some, final.solution.log_sigma)
            yield replace(fitted, found=_as_unsure(fitted, known))


def _rigid(known: MixedModelFit, final: MixedModelFit) -> Iterator[MixedModelFit]:
    """Yield the fit with the catalogue's forms as they are, if there is one."""
    some = tuple(replace(one, given=one.given or ()) for one in known.found)
    with suppress(ModelError, np.linalg.LinAlgError):
        fitted = fit_mixed_model(known.problem, known.theta, some, final.solution.log_sigma)
        yield replace(fitted, found=_as_unsure(fitted, known))


def _asked_for(known: MixedModelFit) -> bool:
    """Return whether mean forces and curves at left-out positions ask for the inferred forms.

    Between the positions a form is interpolated, and stays unless it clearly fails. One in time
    leads away from what was measured, since a prediction is one amid the session: it must gain.
    """
    where, noise = cells(known), variance(known)
    rows = np.concatenate([*where.force, *where.curve, np.zeros(0, dtype=np.int64)])
    if len(position_groups(known)) < FEWEST_POSITIONS or not len(rows):
        return True
    pairs = zip(known.found, known.spans, strict=True)
    forms = [np.arange(span.start + len(one.parameters()), span.stop) for one, span in pairs]
    keep = np.setdiff1d(np.arange(known.linear.columns.shape[1]), np.concatenate(forms))
    rigid = replace(known, linear=with_only(known.linear, keep))
    formed, plain = (np.sum(when_left_out(f)[rows] ** 2 / noise[rows]) for f in (known, rigid))
    slow = any(in_time(one.effect) for one in known.found)
    return bool(plain - formed > (FORM_GAIN_CHI2 if slow else -FORM_GAIN_CHI2))


def _as_unsure(fitted: MixedModelFit, known: MixedModelFit) -> tuple[Found, ...]:
    """Return the effects of a fit with uncertainties that hold their other shapes, too."""
    some = [replace(f, sigma=k.sigma) for f, k in zip(fitted.found, known.found, strict=False)]
    return (*some, *fitted.found[len(some) :])


def _of_form(beta: FloatArray, one: Found, span: slice) -> FloatArray:
    return np.asarray(beta[span.start + len(one.parameters()) : span.stop])


def _with_share(one: Found, share: float) -> Found:
    return replace(one, ways=tuple(replace(way, size=share * way.size) for way in one.ways))


def _unnamed(fitted: MixedModelFit, contender: RankedCandidate, sizes: FloatArray) -> Found:
    """Return what is in no catalogue, all parts of it, with the sizes of its basis shapes."""
    candidate = contender.score.candidate
    every = shapes(fitted, candidate.location, candidate.part)
    ways = tuple(
        FormWay(terms=terms, size=size, sigma=contender.score.scale)
        for shape, size in zip(every, sizes.tolist(), strict=True)
        if (terms := terms_of(fitted.problem.forward, shape))
    )
    effect = free_effect(location(candidate.location))
    values: dict[str, dict[str, float]] = {name: {} for name in fitted.problem.forward.names}
    return Found(effect=effect, values=values, ways=ways)


def terms_of(forward: ForwardModel, shape: BasisShape) -> tuple[Profile, ...]:
    """Return a basis shape as a model file has it, by configuration."""
    result = []
    for name, term in shape.terms.items():
        volts = np.abs(forward.scenes[forward.names.index(name)].voltage_V)
        least_V = float(np.min(volts[volts > 0.0], initial=np.inf))
        result.append(_term(term, name, shape.unit, least_V if np.isfinite(least_V) else 0.0))
    return tuple(result)


def _term(term: BasisTerm, configuration: str, unit: str, full_V: float) -> Profile:
    """Return a basis function as a model file has it."""
    made = sampled(
        term.function, cast("Coordinate", term.along), term.low, term.high, nodes=term.nodes,
        unit=unit, under=cast("Under", term.under), adds=cast("Adds", term.adds),
    )  # fmt: skip
    return replace(made, configurations=(configuration,), full_V=full_V)


def with_bands(one: Found, fitted: MixedModelFit) -> tuple[Profile, ...]:
    """Return the terms of an effect's form, with their standard uncertainty at each node."""
    if not one.ways:
        return one.terms
    span = fitted.spans[fitted.found.index(one)]
    first = span.start + len(one.parameters())
    places = slice(first, first + len(one.ways))
    covariance, result = fitted.solution.covariance[places, places], list[Profile]()
    for total in one.terms:
        by = np.zeros((len(total.at), len(one.ways)))
        for i, way in enumerate(one.ways):
            for term in way.terms:
                if key_of(term) == key_of(total):
                    by[:, i] += term.values
        band = np.sqrt(np.maximum(np.einsum("ti,ij,tj->t", by, covariance, by), 0.0))
        result.append(replace(total, sigma=tuple(np.hypot(band, total.sigma).tolist())))
    return tuple(result)
