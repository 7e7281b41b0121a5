"""Another single name in place of several."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.criticism.wordings import evidence
from model.discrepancy.search.one_name import SingleName
from model.discrepancy.thresholds import (
    EVIDENCE_TEMPERATURE,
    FURTHER_NAME_LN,
    MISSED_BY_FORM_SHARE,
    NEIGHBOUR_EVIDENCE_LN,
    REFINED_EVIDENCE_SHARE,
)
from model.effects import title

PAIR = 2


@dataclass(frozen=True)
class OneName(VerdictCheck):
    """Two weak effects may imitate a third one whose form is not quite the catalogue's."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        names = [one.effect.name for one in named.named]
        odds = dict[str, float]()
        for one in named.single_names:
            missed = min(MISSED_BY_FORM_SHARE * one.explained, NEIGHBOUR_EVIDENCE_LN)
            ahead = max(one.ahead, _ahead_in_words(named, one)) + missed
            if ahead > -NEIGHBOUR_EVIDENCE_LN:
                odds[one.candidate.name] = float(np.exp(min(ahead, 0.0) / EVIDENCE_TEMPERATURE))
        if odds:
            yield Failure(
                consequence=Consequence.INDISTINGUISHABLE,
                sentence=(
                    f"{' or '.join(map(title, odds))} alone explains about as much as"
                    f" {' and '.join(map(title, names))} together"
                ),
                effects=tuple(names),
                rivals=tuple(odds),
                odds=tuple(odds.values()),
            )


def _ahead_in_words(named: NamedModel, one: SingleName) -> float:
    """Return the log odds of a single name against two, each in its best wording.

    As far as a straight line goes from where none of them is.
    """
    if len(named.named) != PAIR:
        return -np.inf
    base, log_sigma = named.outcome.base, named.log_sigma
    first, second = sorted(named.named, key=lambda choice: -choice.ln_bayes_factor)
    rival = one.candidate.score.candidate.effect
    effects = [first.effect, *([] if rival is None else [rival])]
    alone = evidence(base, log_sigma, effects)
    beside = evidence(second.before, log_sigma, [second.effect])
    if one.candidate.name not in alone or first.effect.name not in alone or not beside:
        return -np.inf
    both = alone[first.effect.name] + beside[second.effect.name]
    if abs(both - one.explained) > REFINED_EVIDENCE_SHARE * one.explained:
        return -np.inf  # of strong effects a straight line says little
    return alone[one.candidate.name] - both + FURTHER_NAME_LN


CHECK = OneName(
    name="one_name",
    meaning="no other single name explains as much as all names together",
    order=27,
)
