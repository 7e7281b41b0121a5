"""How likely each location is where something unknown acts: their free forms, compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from model.discrepancy.search.nonparametric_terms import is_nonparametric
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import (
    EVIDENCE_TEMPERATURE,
    LEAST_LOCATION_SHARE,
    LOCATION_FORM_SHARE,
)


def likely_locations(
    free: RankedCandidate, ranking: Sequence[RankedCandidate]
) -> Mapping[str, float]:
    """Return the share of each location that may be it, the likeliest first.

    `free` is the free form that is reported, `ranking` has those of the other locations beside the
    same names. No basis has all of a form: the evidence of the right location may miss a share.
    """
    ln_bayes_factors = {free.score.candidate.location: free.ln_bayes_factor}
    for one in ranking:
        where = one.score.candidate.location
        if is_nonparametric(one.name) and where not in ln_bayes_factors:
            ln_bayes_factors[where] = min(one.ln_bayes_factor, free.ln_bayes_factor)
    width = max(EVIDENCE_TEMPERATURE, LOCATION_FORM_SHARE * free.ln_bayes_factor)
    weights = np.exp((np.array(list(ln_bayes_factors.values())) - free.ln_bayes_factor) / width)
    shares = dict(zip(ln_bayes_factors, (weights / weights.sum()).tolist(), strict=True))
    likely = {where: share for where, share in shares.items() if share >= LEAST_LOCATION_SHARE}
    return dict(sorted(likely.items(), key=lambda item: -item[1]))
