"""The model that is written to the file, with its inferred forms, fitted again with them.

In the search the deviations of a form are linear. Strong ones bend the line; here they become
terms of the model, act through the hooks as in every prediction, and everything is fitted again
from there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import chain
from typing import cast

import numpy as np

from model.discrepancy.search.nonparametric_terms import BasisShape, shapes
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import FORM_GAIN_CHI2
from model.discrepancy.verdict.prediction_error import variance
from model.discrepancy.verdict.written_model.left_out_gain import (
    columns_asked_for,
    forms_asked_for,
    left_out_chi2,
    means_ask_for,
)
from model.discrepancy.verdict.written_model.model_averaging import averaged_over_forms
from model.identification.likelihood.form_error import formed
from model.identification.likelihood.form_ways import sampled
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import with_only
from model.identification.likelihood.mixed_model import weigh
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
    """Yield fits with the forms in the model, and with what is unknown; the likeliest first.

    `final` is `known` with the columns of the free form, if there is one. Inferred forms, and the
    parts of what is unknown, are in the first one only if left-out positions are predicted better
    with them: what they add at the times and places of the session may be anything elsewhere. What
    is unknown is in none unless its gain there is as clear as a name's has to be.
    """
    unnamed = list[Found]()
    if free is not None:
        final, one = _unnamed(known, final, free)
        if one.ways and means_ask_for(known, final):
            unnamed.append(one)
        else:
            final = known
    beta = final.solution.beta
    found = [
        one if one.given is not None
        else formed(known.problem.forward, known.linear, one, _of_form(beta, one, span))
        for one, span in zip(known.found, known.spans, strict=True)
    ]  # fmt: skip
    if not any(one.ways for one in (*found, *unnamed)):
        yield final
        return
    every = chain(_formed(known, final, [*found, *unnamed]), _rigid(known, final))
    if forms_asked_for(known, final):
        yield from _as_good_as_found(final, every)
    else:
        yield from chain(_rigid(known, final, unnamed), every)
    yield known


def _as_good_as_found(
    final: MixedModelFit, offers: Iterator[MixedModelFit]
) -> Iterator[MixedModelFit]:
    """Yield fits as they come, or the best first where the first is worse than what was found.

    A form that the catalogue does not nearly have is no small change of it: with it in the model a
    fit may end elsewhere than the straight line of the search does. Asked where left-out positions
    ask for the form at all: what they say of one in time is no measure of another session.
    """
    noise = variance(final)
    for one in offers:
        if left_out_chi2(one, noise) <= left_out_chi2(final, noise) + FORM_GAIN_CHI2:
            yield one
        else:
            yield from sorted([one, *offers], key=lambda fit: left_out_chi2(fit, noise))


def _formed(
    known: MixedModelFit, final: MixedModelFit, found: Sequence[Found]
) -> Iterator[MixedModelFit]:
    """Yield fits with the forms, begun from all of their deviations and from none."""
    beta, size = final.solution.beta, known.problem.bases.size
    for theta, share in ((final.theta + beta[:size], 1.0), (known.theta, 0.0)):
        some = tuple(_with_share(one, share) for one in found)
        with suppress(ModelError):
            fitted = fit_mixed_model(known.problem, theta, some, final.solution.log_sigma)
            yield replace(fitted, found=_as_unsure(fitted, known))


def _rigid(
    known: MixedModelFit, final: MixedModelFit, unnamed: Sequence[Found] = ()
) -> Iterator[MixedModelFit]:
    """Yield the fit with the catalogue's forms as they are, if there is one."""
    some = (*(replace(one, given=one.given or ()) for one in known.found), *unnamed)
    with suppress(ModelError):
        fitted = fit_mixed_model(known.problem, known.theta, some, final.solution.log_sigma)
        found = _as_unsure(fitted, known) if unnamed else averaged_over_forms(fitted, known)
        yield replace(fitted, found=found)


def _as_unsure(fitted: MixedModelFit, known: MixedModelFit) -> tuple[Found, ...]:
    """Return the effects of a fit with uncertainties that hold their other shapes, too."""
    some = [replace(f, sigma=k.sigma) for f, k in zip(fitted.found, known.found, strict=False)]
    return (*some, *fitted.found[len(some) :])


def _of_form(beta: FloatArray, one: Found, span: slice) -> FloatArray:
    return np.asarray(beta[span.start + len(one.parameters()) : span.stop])


def _with_share(one: Found, share: float) -> Found:
    return replace(one, ways=tuple(replace(way, size=share * way.size) for way in one.ways))


def _unnamed(
    fitted: MixedModelFit, final: MixedModelFit, ranked: RankedCandidate
) -> tuple[MixedModelFit, Found]:
    """Return the fit with the parts of a free form that gain something, and these parts."""
    candidate, span = ranked.score.candidate, final.spans[-1]
    every = shapes(fitted, candidate.location, candidate.part)
    keep = columns_asked_for(final, [shape.part for shape in every])
    if len(keep) < len(every):
        linear = with_only(final.linear, np.concatenate([np.arange(span.start), span.start + keep]))
        span = slice(span.start, span.start + len(keep))
        solution = weigh(linear.data, final.solution.log_sigma)
        final = replace(final, linear=linear, solution=solution, spans=(*final.spans[:-1], span))
    sizes = final.solution.beta[span].tolist()
    ways = tuple(
        FormWay(terms=terms, size=size, sigma=ranked.score.scale)
        for shape, size in zip([every[i] for i in keep], sizes, strict=True)
        if (terms := terms_of(fitted.problem.forward, shape))
    )
    effect = free_effect(location(candidate.location))
    values: dict[str, dict[str, float]] = {name: {} for name in fitted.problem.forward.names}
    return final, Found(effect=effect, values=values, ways=ways)


def terms_of(forward: ForwardModel, shape: BasisShape) -> tuple[Profile, ...]:
    """Return a basis shape as a model file has it, by configuration."""
    result = []
    for name, term in shape.terms.items():
        configuration_model = forward.configuration_models[forward.names.index(name)]
        volts = np.abs(configuration_model.voltage_V)
        least_V = float(np.min(volts[volts > 0.0], initial=np.inf))
        # a relative change of the EIBM is one of what goes with the voltage already
        full_V = least_V if np.isfinite(least_V) and term.adds != "EIBM" else 0.0
        result.append(
            _term(
                term,
                name,
                shape.unit,
                full_V,
                np.unique(configuration_model.stated_m[configuration_model.touching]),
            )
        )
    return tuple(result)


def _term(
    term: BasisTerm, configuration: str, unit: str, full_V: float, positions_m: FloatArray
) -> Profile:
    """Return a basis function as a model file has it.

    Along the arc it has straight lines between the measured positions: waves that follow a jump
    from one of them to the next swing between all others, where nothing was measured.
    """
    made = sampled(
        term.function, cast("Coordinate", term.along), term.low, term.high, nodes=term.nodes,
        unit=unit, under=cast("Under", term.under), adds=cast("Adds", term.adds),
    )  # fmt: skip
    if term.along == "position" and len(positions_m):
        made = replace(
            made, at=tuple(positions_m.tolist()), values=tuple(term(positions_m).tolist()),
            sigma=(0.0,) * len(positions_m),
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
    for total, by in zip(one.terms, by_ways(one), strict=True):
        band = np.sqrt(np.maximum(np.einsum("ti,ij,tj->t", by, covariance, by), 0.0))
        result.append(replace(total, sigma=tuple(np.hypot(band, total.sigma).tolist())))
    return tuple(result)


def by_ways(one: Found) -> list[FloatArray]:
    """Return for each term of an effect's form what the sizes of its ways change, (nodes, ways)."""
    result = []
    for total in one.terms:
        by = np.zeros((len(total.at), len(one.ways)))
        for i, way in enumerate(one.ways):
            for term in way.terms:
                if key_of(term) == key_of(total):
                    by[:, i] += term.values
        result.append(by)
    return result
