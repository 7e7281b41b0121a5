"""Noise of the load cell beyond what load cells have: a force that goes with the place hides in it.

The size of the load cell's noise in a run (its zero, its slow and its quick wander) is estimated
from what the model leaves. A force that no candidate describes, which is another one at each
position but constant there, is taken up by it. Whether it is noise is told by its order: noise does
not come back where the load cell comes back to, and is not smooth along the arc. So where the noise
is larger than usual, a nonparametric term of each location competes with it, the noise estimated
anew beside the term, from the usual size on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.search.evidence import (
    Candidate,
    Projected,
    Score,
    averaged,
    rescored,
    scored,
)
from model.discrepancy.search.nonparametric_terms import unknowns
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import (
    EVIDENCE_THRESHOLD_LN,
    FURTHER_EFFECT_LN,
    NOISE_LEFT_SHARE,
    ORDER_OF_NOISE_LN,
    UNUSUAL_CELL_RATIO,
)
from model.identification.likelihood.mixed_model import Solution, weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit

# of a run's readings, by the name of the random effect
CELL = {
    "force_zero": "zero of the load cell", "sway_slow": "slow wander of the load cell",
    "sway_quick": "quick wander of the load cell",
}  # fmt: skip


def cell_noise_ratio(fitted: MixedModelFit) -> dict[str, float]:
    """Return each part of the load cell's noise over its usual size."""
    known = fitted.problem.noise.random_effects
    return {name: _over_usual(fitted, fitted.solution, name) for name in CELL if name in known}


def at_usual_cell_noise(fitted: MixedModelFit) -> MixedModelFit:
    """Return a fit weighed with the load cell's noise as it usually is, where it is larger."""
    log_sigma, guess = fitted.solution.log_sigma.copy(), fitted.problem.guess
    for k, name in enumerate(fitted.problem.noise.random_effects):
        if name in CELL:
            log_sigma[k] = min(log_sigma[k], guess[k])
    return replace(fitted, solution=weigh(fitted.linear.data, log_sigma))


@dataclass(frozen=True, kw_only=True)
class CellNoise:
    """The noise of the load cell beside a model, where it is larger than usual."""

    name: str  # of the part of it that is so most
    times: float  # of its usual size
    # ln of the Bayes factor of a smooth term against noise, that of any size being as probable
    order: float
    # the best term of each location at the noise that is estimated beside the best one; none: what
    # the noise takes up has no order
    ranking: tuple[RankedCandidate, ...] = ()

    @property
    def term(self) -> RankedCandidate | None:
        """The best of them."""
        return next(iter(self.ranking), None)


def unusual_cell_noise(fitted: MixedModelFit) -> CellNoise | None:
    """Return the load cell's noise beside a model; None: it is as usual.

    It is looked at once for each model.
    """
    kept, key = fitted.linear.at_states, ("cell noise", id(fitted.solution), id(fitted.linear))
    if key not in kept:  # with both, so that nothing else can have their identity
        kept[key] = fitted.solution, fitted.linear, _unusual(fitted)
    found: CellNoise | None = kept[key][2]
    return found


def _unusual(fitted: MixedModelFit) -> CellNoise | None:
    ratio = cell_noise_ratio(fitted)
    name = max(ratio, key=lambda one: ratio[one])
    if ratio[name] <= UNUSUAL_CELL_RATIO:
        return None
    judge, pool = at_usual_cell_noise(fitted), unknowns(fitted)
    first = _scores(judge, pool)
    own = [one for one in first if one.candidate.location == first[0].candidate.location]
    beside = [(value, found) for value, found in (rescored(judge, one) for one in own)
              if _over_usual(fitted, found, name) < NOISE_LEFT_SHARE * ratio[name]]  # fmt: skip
    if not beside:
        return CellNoise(name=name, times=ratio[name], order=-np.inf)
    # a location as a whole and its parts are equally probable beforehand
    paid = float(np.log(len(own) / len(beside)))
    evidence = averaged([value for value, _ in beside]) - paid
    order = averaged([value - _improbable(fitted, found) for value, found in beside]) - paid
    if evidence <= EVIDENCE_THRESHOLD_LN + FURTHER_EFFECT_LN or order <= ORDER_OF_NOISE_LN:
        return CellNoise(name=name, times=ratio[name], order=order)
    _, solution = max(beside, key=lambda one: one[0])
    judge = replace(fitted, solution=weigh(fitted.linear.data, solution.log_sigma))
    best = dict[str, RankedCandidate]()
    for one in _scores(judge, pool):
        ranked = RankedCandidate(score=one, ln_bayes_factor=one.log_bayes, solution=judge.solution)
        best.setdefault(one.candidate.name, ranked)
    return CellNoise(name=name, times=ratio[name], order=order, ranking=tuple(best.values()))


def _over_usual(fitted: MixedModelFit, solution: Solution, name: str) -> float:
    """Return a part of the noise over its usual size, at a solution."""
    k = list(fitted.problem.noise.random_effects).index(name)
    return float(np.exp(solution.log_sigma[k] - fitted.problem.guess[k]))


def _improbable(fitted: MixedModelFit, beside: Solution) -> float:
    """Return how much (ln) less probable the cell's noise is by its size than beside a term.

    That says that it is no noise as cells have it, but not that it has an order.
    """
    result = 0.0
    for name, (_, width) in fitted.problem.noise.random_effects.items():
        if name in CELL:
            both = (_over_usual(fitted, one, name) for one in (fitted.solution, beside))
            large, small = (0.5 * (np.log(ratio) / width) ** 2 for ratio in both)
            result += float(large - small)
    return result


def _scores(judge: MixedModelFit, pool: Sequence[Candidate]) -> list[Score]:
    """Return the scores of nonparametric terms at the noise of a fit, the best first."""
    projected = Projected.of(judge.problem.forward, judge.linear, judge.solution)
    found = scored(judge.problem.forward, projected, pool)
    return sorted(found, key=lambda one: -one.log_bayes)
