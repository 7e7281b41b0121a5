"""Rank all candidates by their log Bayes factors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.discrepancy.search.evidence import (
    Candidate,
    Projected,
    Score,
    allowed,
    averaged,
    candidates,
    rescored,
    scored,
    surprise,
)
from model.discrepancy.search.nonparametric_terms import unknowns
from model.discrepancy.search.outliers import outlier_candidates
from model.discrepancy.thresholds import (
    CLEAR_EVIDENCE_LN,
    CURVATURE_SHARE,
    EQUAL_EVIDENCE_LN,
    HOPELESS_SHARE,
    OTHER_SHAPES,
    RESCORED_CANDIDATES,
    RESCORED_EVIDENCE_LN,
    RESCORED_OUTLIER_LN,
)
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model import Solution, weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit

TINY = 1e-9


@dataclass(frozen=True, kw_only=True)
class RankedCandidate:
    """A candidate with its evidence."""

    score: Score
    ln_bayes_factor: float  # against the present model, averaged over its shapes
    solution: Solution | None = None
    fitted: MixedModelFit | None = None  # where it was refined
    tried: tuple[MixedModelFit, ...] = ()  # fits of all of its shapes that were refined
    shapes: tuple[Score, ...] = ()  # others of the same effect that explain about as much
    compared: tuple[Score, ...] = ()  # all of its shapes, linearised at zero
    # ln of how much less its shapes explain on the average than the best, and of a surprise
    among: float = 0.0

    @property
    def name(self) -> str:
        """Of the effect, `unknown:SLOT`, or `outlier:NUMBER`."""
        return self.score.candidate.name

    @property
    def known(self) -> bool:
        """Whether it is an effect of the catalogue."""
        return self.score.candidate.effect is not None


def best_of_each(scores: Sequence[Score], solution: Solution) -> list[RankedCandidate]:
    """Return the best candidate of each name at a given noise, the best of them all first."""
    best = dict[str, RankedCandidate]()
    for one in sorted(scores, key=lambda one: -one.log_bayes):
        ranked = RankedCandidate(score=one, ln_bayes_factor=one.log_bayes, solution=solution)
        best.setdefault(one.candidate.name, ranked)
    return list(best.values())


def rank(
    fitted: MixedModelFit, effects: Sequence[Effect], locations: bool = True
) -> list[RankedCandidate]:
    """Rank all candidates, best first; estimate the noise together with promising ones.

    The same candidates of the same fit are ranked once.
    """
    kept = fitted.linear.at_states
    of = (fitted.problem, fitted.linear, fitted.solution, *effects)
    key = ("rank", fitted.deviance, locations, *map(id, of))
    if key not in kept:  # with all of it, so that nothing else can have their identity
        kept[key] = of, _ranked(fitted, effects, locations)
    return list(kept[key][1])


def _ranked(
    fitted: MixedModelFit, effects: Sequence[Effect], locations: bool
) -> list[RankedCandidate]:
    inside = {f.effect.name for f in fitted.found}
    every = candidates(fitted, [e for e in effects if e.name not in inside])
    if locations:
        every += unknowns(fitted)
    every += outlier_candidates(fitted)
    scores = _by_name(fitted, every, fitted.solution)
    best = {name: found[0] for name, found in scores.items()}
    usual = best_scores(fitted, every, usual_scatter(fitted))
    # not even with the usual scatter does the rest explain anything
    worth = [n for n, s in usual.items() if s.log_bayes > RESCORED_EVIDENCE_LN]
    hidden = [n for n in worth if not n.startswith("outlier:")][:RESCORED_CANDIDATES]
    result, tried, top = [], 0, 0.0
    for name, one in {**best, **{n: usual[n] for n in hidden if n not in best}}.items():
        outlier = one.candidate.location == "outlier"
        promising = tried < RESCORED_CANDIDATES and one.log_bayes > (
            RESCORED_OUTLIER_LN if outlier else RESCORED_EVIDENCE_LN
        )
        most = max(one.log_bayes, usual[name].log_bayes) if name in usual else one.log_bayes
        hopeless = top > CLEAR_EVIDENCE_LN and most < HOPELESS_SHARE * top
        if hopeless or (not promising and name not in hidden):
            result.append(RankedCandidate(score=one, ln_bayes_factor=one.log_bayes))
            continue
        tried += promising and not outlier
        looks = [one]
        if name in hidden and not _alike(one, usual[name]):
            looks.append(usual[name])
        both = [(*rescored(fitted, look), look) for look in looks]
        ln_bayes_factor, solution, chosen = max(both, key=lambda item: item[0])
        top = max(top, ln_bayes_factor)
        shapes = _other_shapes(chosen, scores.get(name, []))
        among = _among(fitted, [c for c in every if c.name == name], solution)
        among += surprise(chosen)
        result.append(
            RankedCandidate(
                score=chosen,
                ln_bayes_factor=ln_bayes_factor + among,
                solution=solution,
                shapes=shapes,
                compared=tuple(scores.get(name, [])),
                among=among,
            )
        )
    result.sort(key=lambda c: -c.ln_bayes_factor)
    return result


def _among(fitted: MixedModelFit, shapes: Sequence[Candidate], solution: Solution) -> float:
    """Return ln of the mean of what an effect's shapes explain over what the best of them does."""
    if len(shapes) == 1:
        return 0.0
    forward = fitted.problem.forward
    weighed = weigh(fitted.linear.data, solution.log_sigma)
    projected = Projected.of(forward, fitted.linear, weighed)
    found = [one.log_bayes for one in scored(forward, projected, shapes)]
    return averaged(found) - max(found)


def best_scores(
    fitted: MixedModelFit, every: Sequence[Candidate], solution: Solution
) -> dict[str, Score]:
    """Return the best score of each name, at given scatter; best first."""
    return {name: found[0] for name, found in _by_name(fitted, every, solution).items()}


def _by_name(
    fitted: MixedModelFit, every: Sequence[Candidate], solution: Solution
) -> dict[str, list[Score]]:
    """Return the scores of all shapes of each name, at given scatter; best first."""
    forward = fitted.problem.forward
    projected = Projected.of(forward, fitted.linear, solution)
    scores = [s for s in scored(forward, projected, every) if allowed(s)]
    scores.sort(key=lambda s: -s.log_bayes)
    result: dict[str, list[Score]] = {}
    for one in scores:
        result.setdefault(one.candidate.name, []).append(one)
    return {name: _nearest_first(found) for name, found in result.items()}


def _nearest_first(scores: list[Score]) -> list[Score]:
    """Of sizes that explain about as much, tried one by one, that which is most nearly it.

    From one that is many times too large or too small, a fit may not find there.
    """
    effect = scores[0].candidate.effect
    if effect is None or not effect.amplitude.starting_values:
        return scores
    alike = [s for s in scores if s.log_bayes > scores[0].log_bayes - EQUAL_EVIDENCE_LN]
    first = min(alike, key=lambda s: abs(np.log(max(abs(s.amplitude), TINY))))
    return [first, *(s for s in scores if s is not first)]


def _other_shapes(chosen: Score, scores: Sequence[Score]) -> tuple[Score, ...]:
    """Shapes that explain about as much, where effects are refined in all but their shape."""
    known, result = [_shape(chosen)], list[Score]()
    for one in scores:
        least = scores[0].log_bayes - max(EQUAL_EVIDENCE_LN, CURVATURE_SHARE * scores[0].log_bayes)
        if one.log_bayes > least and _shape(one) not in known and len(result) < OTHER_SHAPES:
            known.append(_shape(one))
            result.append(one)
    return tuple(result)


def _shape(one: Score) -> tuple[float, ...]:
    """Return values of the parameters that stay as they are tried."""
    effect = one.candidate.effect
    stay = () if effect is None else effect.parameters[1:]
    return tuple(one.candidate.values[k.name] for k in stay if not (k.log or k.estimated))


def _alike(one: Score, other: Score) -> bool:
    """Return whether they are the same columns of the same scale."""
    return one.candidate is other.candidate and one.scale == other.scale


def usual_scatter(fitted: MixedModelFit) -> Solution:
    """Return the same fit with the scatter limited to its usual size.

    A larger scatter hides effects that act in every set-up.
    """
    least = np.minimum(fitted.solution.log_sigma, fitted.problem.guess)
    return weigh(fitted.linear.data, least)
