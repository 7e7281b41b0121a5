"""Effects to which the straight line from the base model gives a sign that they cannot have.

The base model may be far from the truth where it fits what an effect does to the curves, and not to
the forces: from there even an effect that explains everything seems to be less than none, and it is
no candidate. So where nonparametric terms explain more than any name, such effects of their
locations are fitted all the same, from a usual size on.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial

import numpy as np

from model.discrepancy.search.evidence import candidates, members, surprise
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.search.refinement.other_starts import (
    by_forces,
    of_tried_size,
    refined_again,
)
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model_fit import MixedModelFit


def with_impossible_signs(
    fitted: MixedModelFit, ranking: list[RankedCandidate], effects: Sequence[Effect]
) -> list[RankedCandidate]:
    """Return the ranking with such effects among them, where they explain anything."""
    names = max((one.ln_bayes_factor for one in ranking if one.known), default=0.0)
    free = {
        one.score.candidate.location: one.ln_bayes_factor
        for one in ranking
        if not one.known and one.ln_bayes_factor > max(names, 0.0)
    }
    ranked = {one.name for one in ranking} | {one.effect.name for one in fitted.found}
    begins = (lambda: fitted.theta, cache(partial(by_forces, fitted)))
    found = [
        refined_again(fitted, _begun(fitted, effect), free[effect.location], begins)
        for effect in effects
        if effect.location in free
        and effect.name not in ranked
        and candidates(fitted, [effect])  # not without times, where it needs these
        and not fitted.problem.effort.spent()
    ]
    some = [one for one in found if one.fitted is not None and one.ln_bayes_factor > 0.0]
    return sorted([*ranking, *some], key=lambda one: -one.ln_bayes_factor)


def _begun(fitted: MixedModelFit, effect: Effect) -> RankedCandidate:
    one = of_tried_size(fitted, effect, 0.5)
    among = surprise(one) - float(np.log(len(members(effect))))
    return RankedCandidate(score=one, ln_bayes_factor=-np.inf, among=among)
