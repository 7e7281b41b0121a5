"""Fit the best candidates with all parameters free, from several starting values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache, partial

import numpy as np

from model.discrepancy.search.evidence import Score, rescored
from model.discrepancy.search.ranking import RankedCandidate, best_scores, usual_scatter
from model.discrepancy.search.refinement.fits import doubtful, refined
from model.discrepancy.search.refinement.other_starts import by_forces, refined_again, weakest
from model.discrepancy.thresholds import (
    CLEAR_EVIDENCE_LN,
    CURVATURE_SHARE,
    HOPELESS_SHARE,
    REFINED_AT_USUAL_SCATTER,
    REFINED_CANDIDATES,
    REFINED_EVIDENCE_LN,
    REFINED_EVIDENCE_SHARE,
)
from model.identification.likelihood.mixed_model_fit import MixedModelFit


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
        shapes = (c.score, *(weakest(fitted, c.score) if there is None else ()))
        done[c.name] = refined(fitted, c, shapes, there, _least(done))
    ranked = {c.name: c.ln_bayes_factor for c in chosen}
    some = _promising(fitted, list(done.values()), ranked, ranking[0].ln_bayes_factor)
    promising = sorted(some, key=lambda name: (-done[name].ln_bayes_factor, name))
    for name in promising:
        done[name] = refined(fitted, done[name], done[name].shapes, there, _least(done))
    forces = cache(partial(by_forces, fitted))  # a fit of its own, which few need
    inside = set() if there is None else {one.effect.name for one in there.found}
    begins = (lambda: fitted.theta, forces)
    for name in promising:
        least = max(_worth_a_fit(ranked[name]), _nonparametric(done[name], ranking))
        if name in inside or not doubtful(done[name], least):
            continue
        if fitted.problem.effort.spent():
            break
        done[name] = refined_again(fitted, done[name], least, begins)
    rest = [c for c in ranking if c.name not in done]
    return sorted([*done.values(), *rest], key=lambda c: -c.ln_bayes_factor)


def _worth_a_fit(top: float) -> float:
    """Return the evidence beside that of the best from which on a candidate is fitted."""
    return top - max(REFINED_EVIDENCE_LN, REFINED_EVIDENCE_SHARE * top)


def _least(done: Mapping[str, RankedCandidate]) -> float:
    """Return the same beside candidates that are fitted; 0 where none is."""
    return max(_worth_a_fit(max((c.ln_bayes_factor for c in done.values()), default=0.0)), 0.0)


def _nonparametric(candidate: RankedCandidate, ranking: Sequence[RankedCandidate]) -> float:
    """Return the evidence of the nonparametric terms at an effect's location.

    These have to pay for their many forms: an effect that is there explains more.
    """
    location = candidate.score.candidate.location
    there = (c for c in ranking if not c.known and c.score.candidate.location == location)
    return max((c.ln_bayes_factor for c in there), default=0.0)


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
