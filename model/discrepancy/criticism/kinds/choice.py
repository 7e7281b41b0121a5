"""The choice of a name when positions, or a whole configuration, are left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.search.cross_validation import position_groups, scores_without
from model.discrepancy.thresholds import (
    EQUAL_EVIDENCE_LN,
    EVIDENCE_THRESHOLD_LN,
    REFINED_EVIDENCE_SHARE,
)
from model.effects import title
from model.identification.data.data_vector import Index
from model.identification.likelihood.mixed_model import weigh

HALF = 0.5  # of the cases in which another name may be chosen


@dataclass(frozen=True)
class ChoiceOfName(VerdictCheck):
    """The evidence of each name is computed again without some of the data."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        own = {one.effect.name for one in named.named}
        cases = _left_out(named)
        others = Counter(filter(None, (_other(named, runs, own) for runs in cases)))
        if others and sum(others.values()) > HALF * len(cases):
            rival, times = others.most_common(1)[0]
            if not _comes_close(named, rival):
                return
            first = max(named.named, key=lambda one: one.ln_bayes_factor)
            yield Failure(
                consequence=Consequence.EQUIVALENCE_CLASS,
                sentence=(
                    f"{title(rival)} is chosen in {times} of {len(cases)} cases in which a position"
                    " or a configuration is left out"
                ),
                effects=(first.effect.name,),
                rivals=(rival,),
            )


def _comes_close(named: NamedModel, rival: str) -> bool:
    """Return whether all data leave it about as likely as what was named first.

    Of strong effects the evidence, which is linear, may misjudge a form that the fit decides.
    """
    ln_bayes_factors = {c.name: c.ln_bayes_factor for c in named.outcome.steps[0].ranking}
    first = max(ln_bayes_factors.get(one.effect.name, 0.0) for one in named.named)
    return ln_bayes_factors.get(rival, 0.0) > (1.0 - REFINED_EVIDENCE_SHARE) * first


def _left_out(named: NamedModel) -> list[Index]:
    """Return the runs of each position, and of each configuration where there are several."""
    row_index = named.fitted.problem.forward.row_index
    of = np.array([run[0] for run in row_index.runs])
    names = list(dict.fromkeys(of.tolist()))
    sheets = [np.flatnonzero(of == name) for name in names] if len(names) > 1 else []
    return [*position_groups(named.fitted), *sheets]


def _other(named: NamedModel, runs: Index, own: set[str]) -> str:
    """Return the name that all other runs choose where it is clearly another one; else none."""
    base = named.outcome.base
    judge = replace(base, solution=weigh(base.linear.data, named.log_sigma))
    best: dict[str, float] = {}
    for one in scores_without(judge, named.rivals, runs):
        name = one.candidate.name
        best[name] = max(best.get(name, -np.inf), one.log_bayes)
    first = max(best, key=lambda name: best[name])
    mine = max((value for name, value in best.items() if name in own), default=-np.inf)
    clear = best[first] > max(EVIDENCE_THRESHOLD_LN, mine + EQUAL_EVIDENCE_LN)
    return first if clear and first not in own else ""


CHECK = ChoiceOfName(
    name="choice",
    meaning="the same name is chosen when a position or a configuration is left out",
    order=25,
)
