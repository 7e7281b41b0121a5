"""Compare several names with each single one: two weak effects may imitate another one.

A search adds the best name and then the next. Where the best is not the right one, what it leaves
looks like a further effect, and nothing has asked whether another single name explains both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.discrepancy.search.form_share import form_share
from model.discrepancy.search.forward_selection import SearchResult
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.search.refinement.fits import refined
from model.discrepancy.thresholds import (
    COMPARED_SINGLE_NAMES,
    FURTHER_NAME_LN,
    LEAST_SHARE_OF_SINGLE_NAME,
    LOOSE_FORM_SHARE,
)
from model.identification.likelihood.mixed_model_fit import MixedModelFit


@dataclass(frozen=True, kw_only=True)
class SingleName:
    """An effect that may be there in place of all that are named."""

    candidate: RankedCandidate  # refined
    explained: float  # evidence of the names together
    # log odds against the names, in which a further name is one of many
    ahead: float


def single_names(outcome: SearchResult, names: list[str], final: MixedModelFit) -> list[SingleName]:
    """Return the single names that explain a good part of what several do, the best first.

    `final` is the model with the names.
    """
    if len(names) < 2:
        return []
    base = outcome.base
    explained = 0.5 * (base.deviance - final.deviance) - _paid(outcome, names)
    least = LEAST_SHARE_OF_SINGLE_NAME * explained
    some = [c for c in outcome.steps[0].ranking if c.known and c.name not in names]
    some = [c for c in some if c.ln_bayes_factor > least][:COMPARED_SINGLE_NAMES]
    result = []
    for one in some:
        fitted = one if one.fitted is not None else refined(base, one, (one.score, *one.shapes))
        if fitted.fitted is None or form_share(fitted.fitted, -1) > LOOSE_FORM_SHARE:
            continue
        ahead = fitted.ln_bayes_factor - explained + FURTHER_NAME_LN * (len(names) - 1)
        result.append(SingleName(candidate=fitted, explained=explained, ahead=ahead))
    return sorted(result, key=lambda one: -one.ahead)


def _paid(outcome: SearchResult, names: list[str]) -> float:
    """Return what the names paid for their sizes and shapes, in which they were chosen."""
    paid = 0.0
    for step in outcome.steps:
        one = step.chosen
        if one is not None and one.fitted is not None and one.name in names:
            paid += max(
                0.5 * (step.before.deviance - one.fitted.deviance) - one.ln_bayes_factor, 0.0
            )
    return float(np.maximum(paid, 0.0))
