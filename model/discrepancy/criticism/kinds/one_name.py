"""Another single name in place of several."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.thresholds import (
    EVIDENCE_TEMPERATURE,
    MISSED_BY_FORM_SHARE,
    NEIGHBOUR_EVIDENCE_LN,
)
from model.effects import title


@dataclass(frozen=True)
class OneName(VerdictCheck):
    """Two weak effects may imitate a third one whose form is not quite the catalogue's."""

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        names = [one.effect.name for one in named.named]
        odds = dict[str, float]()
        for one in named.single_names:
            missed = min(MISSED_BY_FORM_SHARE * one.explained, NEIGHBOUR_EVIDENCE_LN)
            ahead = one.ahead + missed
            if ahead > -NEIGHBOUR_EVIDENCE_LN:
                odds[one.candidate.name] = float(np.exp(min(ahead, 0.0) / EVIDENCE_TEMPERATURE))
        if odds:
            yield Failure(
                consequence="alike",
                sentence=(
                    f"{' or '.join(map(title, odds))} alone explains about as much as"
                    f" {' and '.join(map(title, names))} together"
                ),
                effects=tuple(names),
                rivals=tuple(odds),
                odds=tuple(odds.values()),
            )


CHECK = OneName(
    name="one_name",
    meaning="no other single name explains as much as all names together",
    order=27,
)
