"""Count the left-out positions at which each competing name is chosen.

The other names are in place: a second effect that is chosen without any of the positions is as sure
as a first one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from model.discrepancy.search.cross_validation import best_without, position_groups
from model.discrepancy.search.evidence import candidates
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import CROSS_VALIDATED_NAMES
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray


def votes(
    before: MixedModelFit,
    known: Sequence[RankedCandidate],
    log_sigma: FloatArray,
    considered: str = "",
) -> dict[str, float]:
    """Return the share of the positions without which each name explains most.

    `before` is the model without any of the names `known`, which come best first; `log_sigma` is
    the noise beside all that is named, since that model's own has taken up what they do. The best
    names compete, and the one that the search has `considered`.
    """
    some = [c for i, c in enumerate(known) if i < CROSS_VALIDATED_NAMES or c.name == considered]
    effects = [c.score.candidate.effect for c in some]
    pool = candidates(before, [e for e in effects if e is not None])
    groups = position_groups(before)
    if not pool or not groups:
        return {}
    judge = replace(before, solution=weigh(before.linear.data, log_sigma))
    chosen = Counter(best_without(judge, pool, runs).candidate.name for runs in groups)
    return {name: times / len(groups) for name, times in chosen.items()}
