"""Fit the best candidates with all parameters free, from several starting values."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from itertools import islice

import numpy as np

from model.discrepancy.search.evidence import Candidate, Score, rescored, unit_values
from model.discrepancy.search.form_share import form_share
from model.discrepancy.search.ranking import RankedCandidate, best_scores, usual_scatter
from model.discrepancy.thresholds import (
    CLEAR_EVIDENCE_LN,
    CURVATURE_SHARE,
    DOUBTFUL_FORM_SHARE,
    DOUBTFUL_SCATTER_RATIO,
    EQUAL_EVIDENCE_LN,
    FORM_SHARE_LIMIT,
    HOPELESS_SHARE,
    REFINED_AT_USUAL_SCATTER,
    REFINED_CANDIDATES,
    REFINED_EVIDENCE_LN,
    REFINED_EVIDENCE_SHARE,
)
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model_fit import (
    MixedModelFit,
    approach,
    fit_mixed_model,
)
from model.identification.likelihood.model_state import FitPlace, Found
from model.identification.likelihood.random_effects import ASSUMED
from model.measurements import FloatArray, ModelError

STRICT = 0.1  # of the tolerance of a form, where its size is looked for first
ROUGH_STEPS = 2  # of a fit that only says where to begin
VAGUE_M = 1.0  # of numbers that are not to count
INSIDE = 0.9  # of its bounds that a size may have to begin with


def refine_best(
    fitted: MixedModelFit, ranking: list[RankedCandidate], there: MixedModelFit | None = None
) -> list[RankedCandidate]:
    """Return the effects of the catalogue that are close to the best one, refined; best first.

    `there` is a fit with one effect more, where the fit of that one begins.
    """
    known = [c for c in ranking if c.known]
    if not known:
        return ranking
    chosen = [c for c in known if c.ln_bayes_factor >= _worth_a_fit(known[0].ln_bayes_factor)][
        :REFINED_CANDIDATES
    ]
    plain = _plain(fitted, known)
    chosen += [c for c in known if c.name in plain and c not in chosen]
    done = dict[str, RankedCandidate]()
    for c in chosen:
        done[c.name] = refined(fitted, c, (c.score,), there, _least(done))
    ranked = {c.name: c.ln_bayes_factor for c in chosen}
    some = _promising(fitted, list(done.values()), ranked, ranking[0].ln_bayes_factor)
    promising = sorted(some, key=lambda name: (-done[name].ln_bayes_factor, name))
    for name in promising:
        done[name] = refined(fitted, done[name], done[name].shapes, there, _least(done))
    forces = cache(partial(by_forces, fitted))  # a fit of its own, which few need
    inside = set() if there is None else {one.effect.name for one in there.found}
    doubtful = [name for name in promising if _doubtful(done[name], ranked[name])]
    for name in [name for name in doubtful if name not in inside]:
        if fitted.problem.effort.spent():
            break
        begins = (lambda: fitted.theta, forces)
        done[name] = _refined_again(fitted, done[name], ranked[name], begins)
    rest = [c for c in ranking if c.name not in done]
    return sorted([*done.values(), *rest], key=lambda c: -c.ln_bayes_factor)


def _worth_a_fit(top: float) -> float:
    """Return the evidence beside that of the best from which on a candidate is fitted."""
    return top - max(REFINED_EVIDENCE_LN, REFINED_EVIDENCE_SHARE * top)


def _least(done: Mapping[str, RankedCandidate]) -> float:
    """Return the same beside candidates that are fitted; 0 where none is."""
    return max(_worth_a_fit(max((c.ln_bayes_factor for c in done.values()), default=0.0)), 0.0)


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
            theta, found = fitted.theta, (*fitted.found, _found(fitted, one, one.amplitude))
        other = settled(fitted, theta, found, noise, worthless)
        result = _better(fitted, result, one, other)
    return result


def _same_shape(there: MixedModelFit, one: Score) -> Found | None:
    """Return the effect of a fit that is a candidate in the same shape; None: it has none."""
    for found in there.found:
        if found.effect.name == one.candidate.name:
            values = next(iter(found.values.values()))
            stay = (k.name for k in found.effect.parameters[1:] if not (k.log or k.estimated))
            return found if all(values[n] == one.candidate.values[n] for n in stay) else None
    return None


def by_forces(fitted: MixedModelFit) -> FloatArray:
    """Return the base parameters fitted to forces and to the curves at 0 V, roughly.

    Curves under voltage may contain the effect that is to be explained. Fits begin there: two steps
    bring them as near as they need to be.
    """
    problem, forward = fitted.problem, fitted.problem.forward
    vague = np.zeros(forward.row_index.size)
    for block, configuration_model in zip(
        forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        vague[block.mode_rows[configuration_model.voltage_V != 0.0].ravel()] = VAGUE_M**2
    noise = replace(problem.noise, fixed=problem.noise.fixed + vague)
    theta = fitted.theta
    with suppress(ModelError, np.linalg.LinAlgError):
        steps = approach(replace(problem, noise=noise), fitted.theta, fitted.found)
        for there in islice(steps, ROUGH_STEPS):
            theta = there.theta
    return theta


def _refined_again(
    fitted: MixedModelFit,
    candidate: RankedCandidate,
    promised: float,
    begins: Sequence[Callable[[], FloatArray]],
) -> RankedCandidate:
    """From other beginnings: a straight line from where the effect is absent may lead nowhere.

    It begins at a usual size or where it leads with the usual scatter, lets nothing hide in
    scatter or form, and only then lets the form differ; not twice from the same place.
    """
    one = candidate.score
    usual = best_scores(fitted, [one.candidate], usual_scatter(fitted)).get(candidate.name)
    size = 1.0 if usual is None else usual.amplitude
    first = _found(fitted, one, float(np.copysign(max(1.0, abs(size)), size)))
    found = (*fitted.found, first)
    places: list[FitPlace] = []
    for begin in begins:
        strict = _approached(fitted, begin(), found, places)
        if strict is None:
            continue
        places.append(strict)
        freed = settled(fitted, strict.theta, strict.found, strict.log_sigma)
        candidate = _better(fitted, candidate, one, freed)
        if freed is None or form_share(freed, -1) > FORM_SHARE_LIMIT:
            # its deviation may have taken the place of its size: the catalogue's form may do
            bound = (*strict.found[:-1], replace(strict.found[-1], form=STRICT))
            kept = settled(fitted, strict.theta, bound, strict.log_sigma)
            candidate = _better(fitted, candidate, one, kept)
        if not _doubtful(candidate, promised):
            break
    return candidate


def _approached(
    fitted: MixedModelFit, theta: FloatArray, found: tuple[Found, ...], known: Sequence[FitPlace]
) -> FitPlace | None:
    """Return where a fit leads whose forms may hardly differ; None: nowhere, or to a known place.

    As in `settled`, it is made once from the same beginning.
    """
    kept, key = fitted.linear.at_states, ("approached", *_beginning(fitted, theta, found, None))
    sigma = np.sqrt(np.maximum(np.diag(fitted.solution.covariance), 0.0))
    if key not in kept:
        try:
            for there in approach(fitted.problem, theta, found, None, STRICT):
                if any(there.near(one, sigma) for one in known):
                    return None
            kept[key] = there
        except (ModelError, np.linalg.LinAlgError):
            kept[key] = None
    result: FitPlace | None = kept[key]
    return result


def _better(
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
    if not preferred(_fit(other), _fit(best)):
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


def _fit(fitted: MixedModelFit) -> tuple[float, float]:
    return fitted.deviance, form_share(fitted, -1)


def _found(fitted: MixedModelFit, one: Score, amplitude: float) -> Found:
    """Return a scored effect at a multiple of its own size."""
    effect = one.candidate.effect
    if effect is None:
        raise TypeError(f"{one.candidate.name} is no effect of the catalogue")
    width = max(one.scale, 2.0 * abs(one.amplitude), 2.0 * abs(amplitude))
    values = _begun(fitted, effect, one.candidate, amplitude)
    return Found(effect=effect, values=values, width=width)


def _begun(
    fitted: MixedModelFit, effect: Effect, candidate: Candidate, amplitude: float
) -> dict[str, dict[str, float]]:
    """Return starting values at a multiple of its amplitude, equal in all configurations."""
    size, values = effect.amplitude, unit_values(effect, candidate.values, amplitude)
    if not (size.starting_values or size.log):
        low, high = INSIDE * size.low, INSIDE * size.high
        values[size.name] = float(np.clip(values[size.name], low, high))
    return {name: dict(values) for name in fitted.problem.forward.names}


def _strained(fitted: MixedModelFit) -> bool:
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
    key = ("settled", *_beginning(fitted, theta, found, log_sigma))
    known = key if key in kept else (*key, worthless)
    if known not in kept:
        there = None
        with suppress(ModelError, np.linalg.LinAlgError):
            there = fit_mixed_model(fitted.problem, theta, found, log_sigma, worthless=worthless)
        # one that may have been given up is none for a caller with another limit
        whole = worthless == np.inf or there is None or there.deviance <= worthless
        known = key if whole else known
        kept[known] = there
    result: MixedModelFit | None = kept[known]
    return result


def _beginning(
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


def _promising(
    fitted: MixedModelFit,
    done: list[RankedCandidate],
    ranked: Mapping[str, float],
    most: float,
) -> set[str]:
    """Return the one that explains most, and those that would with the usual scatter.

    Not those that are too weak for any verdict (see `ranking`) beside `most`, the evidence of the
    best candidate: refined, as they were `ranked`, and with the scatter estimated from the usual
    one on. One that was ranked above all that the fits have found may have ended at a wrong place.
    """
    top = max(done, key=lambda c: c.ln_bayes_factor)
    above = max(done, key=lambda c: ranked[c.name])
    most = max(most, top.ln_bayes_factor)
    usual = replace(fitted, solution=usual_scatter(fitted))
    scores = best_scores(usual, [c.score.candidate for c in done], usual.solution)
    weak = HOPELESS_SHARE * most if most > CLEAR_EVIDENCE_LN else -np.inf
    own = {c.name: max(c.ln_bayes_factor, ranked[c.name]) for c in done}
    lost = {above.name} if ranked[above.name] > top.ln_bayes_factor else set[str]()
    return {top.name} | lost | {
        name for name in _foremost(scores)
        if own[name] >= weak or rescored(usual, scores[name])[0] >= weak
    }  # fmt: skip


def _plain(fitted: MixedModelFit, candidates: list[RankedCandidate]) -> list[str]:
    """Return the best candidates at the usual scatter."""
    every = [c.score.candidate for c in candidates]
    return _foremost(best_scores(fitted, every, usual_scatter(fitted)))


def _foremost(scores: Mapping[str, Score]) -> list[str]:
    """Return the first of some names with their scores, and another one that comes close."""
    best = max((s.log_bayes for s in scores.values()), default=0.0)
    close = [n for n, s in scores.items() if s.log_bayes >= (1.0 - CURVATURE_SHARE) * best]
    return close[:REFINED_AT_USUAL_SCATTER]


def _doubtful(candidate: RankedCandidate, promised: float) -> bool:
    """Return whether its size may have been found at the wrong place.

    `promised` is the evidence of the straight line that led there.
    """
    best = candidate.fitted
    if best is None or candidate.ln_bayes_factor < _worth_a_fit(promised):
        return True
    return form_share(best, -1) > DOUBTFUL_FORM_SHARE or _strained(best)
