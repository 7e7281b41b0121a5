"""The evidence of a further effect beside others, whose forms are known only so well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.discrepancy.search.evidence import Projected, rescored, score
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import NEIGHBOUR_FORM_SHARE
from model.identification.likelihood.form_error import whole_step
from model.identification.likelihood.mixed_model import estimate, weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.noise.row_covariance import Data
from model.measurements import FloatArray

ROUGH = 0.02  # of the deviance, to which the scatter is estimated


def evidence_beside(fitted: MixedModelFit, candidate: RankedCandidate) -> float:
    """Return the evidence of a further effect where the contributions of the others are uncertain.

    An effect that is small against them everywhere may be a remainder of their form. The scatter is
    estimated anew, so that nothing is taken off twice: what is uncertain is no longer in it.
    """
    if not fitted.found or candidate.ln_bayes_factor <= 0.0:
        return candidate.ln_bayes_factor
    both = fitted, _doubted(fitted)
    return _kept(candidate, *(rescored(one, candidate.score)[0] for one in both))


def evidence_beside_at_usual_noise(fitted: MixedModelFit, candidate: RankedCandidate) -> float:
    """Return the same for what hides in noise: it is what it usually is, where it is not less."""
    if not fitted.found:
        return candidate.ln_bayes_factor
    forward, linear = fitted.problem.forward, fitted.linear
    usual = np.minimum(fitted.solution.log_sigma, fitted.problem.guess)
    projected = (
        Projected.of(forward, linear, weigh(one, usual)) for one in (linear.data, _doubt(fitted))
    )
    found = (score(forward, one, candidate.score.candidate).log_bayes for one in projected)
    return _kept(candidate, *found)


def _kept(candidate: RankedCandidate, certain: float, doubted: float) -> float:
    """Return a candidate's evidence, less by the share that doubt takes off."""
    share = float(np.clip(doubted / certain, 0.0, 1.0)) if certain > 0.0 else 1.0
    return share * candidate.ln_bayes_factor


def _doubted(fitted: MixedModelFit) -> MixedModelFit:
    """Return a model in which the contributions of all effects are uncertain.

    It is made once for each model.
    """
    kept, key = fitted.linear.at_states, ("doubted", id(fitted.solution))
    if key not in kept:  # with it, so that nothing else can have its identity
        data, guess = _doubt(fitted), fitted.problem.guess
        solution = estimate(data, guess, fitted.solution.log_sigma, ROUGH)
        kept[key] = fitted.solution, replace(
            fitted, linear=replace(fitted.linear, data=data), solution=solution,
            deviance=solution.deviance,
        )  # fmt: skip
    result: MixedModelFit = kept[key][1]
    return result


def _doubt(fitted: MixedModelFit) -> Data:
    """Return the data of a model in which the contributions of all effects are uncertain."""
    data = fitted.linear.data
    doubt = fitted.problem.forward.row_index.pad((NEIGHBOUR_FORM_SHARE * _rows(fitted)) ** 2)
    return replace(data, fixed=data.fixed + doubt)


def _rows(fitted: MixedModelFit) -> FloatArray:
    """Return the contribution of all effects of a model to the rows, (N,)."""
    forward, active = fitted.problem.forward, fitted.active
    rows = np.zeros(forward.row_index.size)
    for one in active:
        others = tuple(a for a in active if a is not one)
        for c, state in enumerate(fitted.linear.states):
            if forward.names[c] in one.values:
                step = whole_step(forward, c, state, state.base, others, one)
                rows += np.abs(forward.rows_of(c, state, step))
    return rows
