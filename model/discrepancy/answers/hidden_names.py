"""The probability of names that others, or something unknown, may hide.

The form of a strong effect differs from the catalogue's, or it is the catalogue's and a weak effect
of another name is there besides. Which of them explains more is told by the evidence; beforehand a
further name is one of many. Something unknown that stands for all names stands for what it is not,
too, as long as nothing is looked for beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from model.discrepancy.search.beside_strict_forms import hidden_names
from model.discrepancy.search.evidence import candidates
from model.discrepancy.search.ranking import best_scores
from model.discrepancy.thresholds import (
    BESIDE_UNKNOWN_SHARE,
    EVIDENCE_TEMPERATURE,
    EVIDENCE_THRESHOLD_LN,
    FURTHER_EFFECT_LN,
    FURTHER_NAME_LN,
    HIDDEN_NAME_LN,
    LEAST_HIDDEN,
)
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model_fit import MixedModelFit


def hidden_chances(known: MixedModelFit, effects: Sequence[Effect]) -> dict[str, float]:
    """Return the names that may be there besides those of a model, with their probability."""
    found = [one for one in hidden_names(known, effects) if one.ln_bayes_factor >= HIDDEN_NAME_LN]
    return _chances({one.name: one.ahead for one in found})


def chances_beside_unknown(
    base: MixedModelFit, final: MixedModelFit, effects: Sequence[Effect]
) -> dict[str, float]:
    """Return names that may be there beside something unknown, with their probability.

    `final` has its free form. They explain as much as a further name needs, and most of what they
    explain by themselves: the free form is none of that.
    """
    inside = {one.effect.name for one in final.found}
    others = [one for one in effects if one.name not in inside]
    alone, beside = (
        best_scores(fitted, candidates(fitted, others), fitted.solution) for fitted in (base, final)
    )
    least = {
        name: max(_ENOUGH, BESIDE_UNKNOWN_SHARE * one.log_bayes) for name, one in alone.items()
    }
    found = {
        name: one.log_bayes
        for name, one in beside.items()
        if one.log_bayes >= least.get(name, _ENOUGH)
    }
    # they explain the same, so the best leaves little to the others
    over = max([0.0, *(ahead - _ENOUGH for ahead in found.values())])
    return _chances({name: ahead - over for name, ahead in found.items()})


# with more the search would have named it, were nothing else there
_ENOUGH = EVIDENCE_THRESHOLD_LN + FURTHER_EFFECT_LN


def _chances(ahead_ln: Mapping[str, float]) -> dict[str, float]:
    """Return the probability of names by how much more they explain than nothing further, in ln."""
    ahead = np.array([FURTHER_NAME_LN, *(min(one, _ENOUGH) for one in ahead_ln.values())])
    odds = np.exp((ahead - np.max(ahead)) / EVIDENCE_TEMPERATURE)
    _, *chances = (odds / np.sum(odds)).tolist()
    each = zip(ahead_ln, chances, strict=True)
    return {name: chance for name, chance in each if chance >= LEAST_HIDDEN}
