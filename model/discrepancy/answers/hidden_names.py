"""The probability of names that the forms of others may hide.

The form of a strong effect differs from the catalogue's, or it is the catalogue's and a weak effect
of another name is there besides. Which of them explains more is told by the evidence; beforehand a
further name is one of many.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model.discrepancy.search.beside_strict_forms import hidden_names
from model.discrepancy.thresholds import (
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
    enough = EVIDENCE_THRESHOLD_LN + FURTHER_EFFECT_LN  # with more the search would have named it
    ahead = np.array([FURTHER_NAME_LN, *(min(one.ahead, enough) for one in found)])
    odds = np.exp((ahead - np.max(ahead)) / EVIDENCE_TEMPERATURE)
    _, *chances = (odds / np.sum(odds)).tolist()
    each = zip((one.name for one in found), chances, strict=True)
    return {name: chance for name, chance in each if chance >= LEAST_HIDDEN}
