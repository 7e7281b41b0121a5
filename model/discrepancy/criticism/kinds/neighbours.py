"""Names of the same location that explain about as much."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.criticism.check_result import Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.search.evidence import Projected
from model.discrepancy.search.form_share import steps_of
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import NEIGHBOUR_EVIDENCE_LN, SEPARATION_SIGMA
from model.discrepancy.verdict.posterior import Choice
from model.effects import title
from model.identification.likelihood.linearisation import with_only
from model.identification.likelihood.mixed_model import weigh
from model.locations import location


@dataclass(frozen=True)
class Neighbours(VerdictCheck):
    """What acts at the same place imitates a name, where nothing in the data tells them apart.

    Two conditions make a rival: its evidence comes close, and its form, with its tolerance, takes
    up what the name adds to the data but for a few standard deviations.
    """

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        names = {one.effect.name for one in named.named}
        for one in named.named:
            rivals = tuple(
                c.name for c in one.ranking
                if c.name not in names and _comes_close(one, c) and _imitates(named, one, c)
            )  # fmt: skip
            if rivals:
                yield Failure(
                    consequence="alike",
                    sentence=(
                        f"these data do not tell {title(one.effect.name)} from"
                        f" {' or '.join(map(title, rivals))}"
                    ),
                    effects=(one.effect.name,),
                    rivals=rivals,
                )


def _comes_close(one: Choice, rival: RankedCandidate) -> bool:
    candidate = rival.score.candidate
    same = rival.known and candidate.location == one.effect.location
    if not same or location(candidate.location).in_time:
        return False
    own = next((c.gain for c in one.ranking if c.name == one.effect.name), one.gain)
    return rival.gain > own - NEIGHBOUR_EVIDENCE_LN


def _imitates(named: NamedModel, one: Choice, rival: RankedCandidate) -> bool:
    """Return whether a rival in the name's place leaves too little of it to be seen."""
    fitted, candidate = named.fitted, rival.score.candidate
    index = next(i for i, f in enumerate(fitted.found) if f.effect.name == one.effect.name)
    forward, span = fitted.problem.forward, fitted.spans[index]
    whole = np.zeros(forward.layout.size)
    for c, step in steps_of(fitted, index):
        whole += forward.rows_of(c, fitted.linear.states[c], step)
    keep = np.setdiff1d(np.arange(fitted.linear.columns.shape[1]), np.arange(span.start, span.stop))
    linear = with_only(fitted.linear, keep)
    S = np.concatenate([whole[:, None], candidate.columns], axis=1)
    A, _ = Projected.of(forward, linear, weigh(linear.data, fitted.solution.log_sigma)).normal(
        forward, S
    )
    size = max(rival.score.scale, abs(rival.score.amplitude))
    inner = A[1:, 1:] + np.diag(np.full(candidate.columns.shape[1], size**-2.0))
    left = float(A[0, 0] - A[0, 1:] @ np.linalg.solve(inner, A[1:, 0]))
    return left < SEPARATION_SIGMA**2


CHECK = Neighbours(
    name="neighbours",
    meaning="the data tell each name from others of the same location",
    order=26,
)
