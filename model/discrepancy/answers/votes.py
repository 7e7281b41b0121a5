"""What left-out positions say of the names that compete for one question.

The other names are in place: a second effect that is chosen without any of the positions is as sure
as a first one. Evidence takes all rows for independent, but what a wrong form leaves in them is
not. How much the evidence of one answer over another differs from position to position says how far
it can be trusted (after Vuong 1989, Econometrica 57, 307; standard errors by the jackknife: Tukey
1958, Ann. Math. Stat. 29, 614).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from model.discrepancy.search.cross_validation import position_groups, scores_without
from model.discrepancy.search.evidence import Candidate, Score, candidates
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import COMPARED_NAMES, CROSS_VALIDATED_NAMES
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray

EQUAL_LN = 2.0  # standard error that any log Bayes factor has at least


@dataclass(frozen=True)
class LeftOutEvidence:
    """Evidence of names without each of the positions."""

    votes: Mapping[str, float] = field(default_factory=dict)  # share of the positions
    # log Bayes factor of each name and free form without each of the positions
    without: Mapping[str, FloatArray] = field(default_factory=dict)

    def sure(self, log_bayes: float, one: str, other: str) -> float:
        """Return the log Bayes factor of one over the other, in its own standard errors."""
        sigma = EQUAL_LN
        if one in self.without and other in self.without:
            each = self.without[one] - self.without[other]
            sigma = float(np.hypot(sigma, np.sqrt((len(each) - 1) * np.var(each))))
        return log_bayes / sigma


def left_out_evidence(
    before: MixedModelFit,
    ranking: Sequence[RankedCandidate],
    log_sigma: FloatArray,
    considered: str = "",
) -> LeftOutEvidence:
    """Return the evidence of the best names, and of the best free form, without each position.

    `before` is the model without any of the names of the ranking; `log_sigma` is the noise beside
    all that is named, since that model's own has taken up what they do. The best names vote, and
    the one that the search has `considered`.
    """
    known = sorted((c for c in ranking if c.known), key=lambda c: -c.gain)
    some = [c for i, c in enumerate(known) if i < COMPARED_NAMES or c.name == considered]
    voting = {c.name for i, c in enumerate(some) if i < CROSS_VALIDATED_NAMES}
    effects = [c.score.candidate.effect for c in some]
    pool: list[Candidate] = candidates(before, [e for e in effects if e is not None])
    groups = position_groups(before)
    if not pool or not groups:
        return LeftOutEvidence()
    pool += [c.score.candidate for c in ranking if c.name.startswith("unknown:")][:1]
    judge = replace(before, solution=weigh(before.linear.data, log_sigma))
    found = [_best(scores_without(judge, pool, runs)) for runs in groups]
    names = dict.fromkeys(one.name for one in pool)
    voting.add(considered)
    chosen = Counter(
        max((s for n, s in one.items() if n in voting), key=lambda s: s.log_bayes).candidate.name
        for one in found
    )
    return LeftOutEvidence(
        {name: times / len(groups) for name, times in chosen.items()},
        {name: np.array([one[name].log_bayes for one in found]) for name in names},
    )


def _best(scores: Sequence[Score]) -> dict[str, Score]:
    """Return the best score of each name."""
    result: dict[str, Score] = {}
    for one in sorted(scores, key=lambda s: s.log_bayes):
        result[one.candidate.name] = one
    return result
