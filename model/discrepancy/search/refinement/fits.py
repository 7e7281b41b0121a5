"""Fits of a model with one effect more, and which of two is better."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from model.discrepancy.search.evidence import Candidate, Score, unit_values
from model.discrepancy.search.form_share import form_share
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import (
    DOUBTFUL_FORM_SHARE,
    DOUBTFUL_SCATTER_RATIO,
    EQUAL_EVIDENCE_LN,
    FORM_SHARE_LIMIT,
)
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model_fit import MixedModelFit, fit_mixed_model
from model.identification.likelihood.model_state import Found
from model.identification.likelihood.random_effects import ASSUMED
from model.measurements import FloatArray, ModelError

INSIDE = 0.9  # of its bounds that a size may have to begin with


def refined(
    fitted: MixedModelFit,
    candidate: RankedCandidate,
    shapes: Sequence[Score],
    there: MixedModelFit | None = None,
    least: float = 0.0,
) -> RankedCandidate:
    """Fit the model with the effect in it, linearised at the fitted values.

    The fits decide between several shapes: linearised at zero they are indistinguishable. `there`
    is as in `refine_best`. A fit that does not come to an end is given up with less than `least`
    evidence.
    """
    worthless = fitted.deviance - 2.0 * least
    known = None if candidate.solution is None else candidate.solution.log_sigma
    result = candidate
    for one in shapes:
        own, noise = None if there is None else _same_shape(there, one), known
        if there is not None and own is not None:
            theta, noise = there.theta, there.solution.log_sigma
            found = (*(f for f in there.found if f is not own), own)
        else:
            # where a straight line leads the base may be in another valley
            theta, found = fitted.theta, (*fitted.found, begun_at(fitted, one, one.amplitude))
        other = settled(fitted, theta, found, noise, worthless)
        result = better(fitted, result, one, other)
    return result


def _same_shape(there: MixedModelFit, one: Score) -> Found | None:
    """Return the effect of a fit that is a candidate in the same shape; None: it has none."""
    for found in there.found:
        if found.effect.name == one.candidate.name:
            values = next(iter(found.values.values()))
            stay = (k.name for k in found.effect.parameters[1:] if not (k.log or k.estimated))
            return found if all(values[n] == one.candidate.values[n] for n in stay) else None
    return None


def better(
    fitted: MixedModelFit, candidate: RankedCandidate, one: Score, other: MixedModelFit | None
) -> RankedCandidate:
    """Return the candidate, with this shape and fit where they are better than its own."""
    best = candidate.fitted
    if other is None:
        return candidate
    candidate = replace(candidate, tried=(*candidate.tried, other))
    # its size was chosen from several, as in `score`
    ln_bayes_factor = 0.5 * (fitted.deviance - other.deviance) - float(
        np.log(len(one.candidate.sizes))
    )
    ln_bayes_factor += candidate.among
    if best is None:
        return replace(candidate, score=one, ln_bayes_factor=ln_bayes_factor, fitted=other)
    if not preferred(_quality(other), _quality(best)):
        return candidate
    # the effect explains what its best shape does
    if ln_bayes_factor > candidate.ln_bayes_factor - EQUAL_EVIDENCE_LN:
        ln_bayes_factor = max(ln_bayes_factor, candidate.ln_bayes_factor)
    return replace(candidate, score=one, ln_bayes_factor=ln_bayes_factor, fitted=other)


def preferred(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Return whether a fit (its deviance, share of deviation from its form) is better than another.

    Mostly deviation comes last. Of two that explain about as much, the one that needs less of it
    is better: a shape may imitate another one by its deviation.
    """
    loose, otherwise = (fit[1] > FORM_SHARE_LIMIT for fit in (one, other))
    if loose != otherwise:
        return otherwise
    if abs(one[0] - other[0]) < 2.0 * EQUAL_EVIDENCE_LN:
        return one[1] < other[1]
    return one[0] < other[0]


def _quality(fitted: MixedModelFit) -> tuple[float, float]:
    return fitted.deviance, form_share(fitted, -1)


def begun_at(fitted: MixedModelFit, one: Score, amplitude: float) -> Found:
    """Return a scored effect at a multiple of its own size."""
    effect = one.candidate.effect
    if effect is None:
        raise TypeError(f"{one.candidate.name} is no effect of the catalogue")
    width = max(one.scale, 2.0 * abs(one.amplitude), 2.0 * abs(amplitude))
    values = _values(fitted, effect, one.candidate, amplitude)
    return Found(effect=effect, values=values, width=width)


def _values(
    fitted: MixedModelFit, effect: Effect, candidate: Candidate, amplitude: float
) -> dict[str, dict[str, float]]:
    """Return starting values at a multiple of its amplitude, equal in all configurations."""
    size, values = effect.amplitude, unit_values(effect, candidate.values, amplitude)
    if not (size.starting_values or size.log):
        low, high = INSIDE * size.low, INSIDE * size.high
        values[size.name] = float(np.clip(values[size.name], low, high))
    return {name: dict(values) for name in fitted.problem.forward.names}


def doubtful(candidate: RankedCandidate, least: float) -> bool:
    """Return whether its size may have been found at the wrong place.

    `least` is the evidence that it has where it is the right one.
    """
    best = candidate.fitted
    if best is None or candidate.ln_bayes_factor < least:
        return True
    return form_share(best, -1) > DOUBTFUL_FORM_SHARE or strained(best)


def strained(fitted: MixedModelFit) -> bool:
    """Return whether set-ups seem to differ by much more than is usual."""
    times = fitted.solution.log_sigma - fitted.problem.guess
    return bool(np.max(times[: len(ASSUMED)]) > np.log(DOUBTFUL_SCATTER_RATIO))


def settled(
    fitted: MixedModelFit,
    theta: FloatArray,
    found: tuple[Found, ...],
    log_sigma: FloatArray | None,
    worthless: float = np.inf,
) -> MixedModelFit | None:
    """Return a model with these effects, from there on; None where it does not settle.

    A fit from the same place is made once: the search may come back to a model with fewer
    candidates. `worthless` is as in `fit_mixed_model`.
    """
    kept = fitted.linear.at_states
    key = ("settled", *beginning(fitted, theta, found, log_sigma))
    known = key if key in kept else (*key, worthless)
    if known not in kept:
        there = None
        with suppress(ModelError):
            there = fit_mixed_model(fitted.problem, theta, found, log_sigma, worthless=worthless)
        # one that may have been given up is none for a caller with another limit
        whole = worthless == np.inf or there is None or there.deviance <= worthless
        known = key if whole else known
        kept[known] = there
    result: MixedModelFit | None = kept[known]
    return result


def beginning(
    fitted: MixedModelFit,
    theta: FloatArray,
    found: tuple[Found, ...],
    log_sigma: FloatArray | None,
) -> tuple[Hashable, ...]:
    """Return what the end of a fit depends on."""
    return (
        id(fitted.problem), theta.tobytes(), repr([(f.effect.name, f) for f in found]),
        None if log_sigma is None else log_sigma.tobytes(),
    )  # fmt: skip
