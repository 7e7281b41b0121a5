"""Names that explain about as much, and the same."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.contract import VerdictCheck
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.criticism.wordings import evidence, wordings
from model.discrepancy.search.evidence import Candidate, Projected
from model.discrepancy.search.form_share import steps_of
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import (
    EQUAL_EVIDENCE_LN,
    EVIDENCE_TEMPERATURE,
    FURTHER_NAME_LN,
    NEIGHBOUR_EVIDENCE_LN,
    SEPARATION_SIGMA,
)
from model.discrepancy.verdict.messages import shortened
from model.discrepancy.verdict.posterior import Choice
from model.effects import title
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import with_only
from model.identification.likelihood.mixed_model import weigh
from model.locations import location
from model.measurements import FloatArray


@dataclass(frozen=True)
class Neighbours(VerdictCheck):
    """Another name imitates one, where nothing in the data tells them apart.

    Two conditions make a rival: in one of its wordings its evidence comes close, and takes up what
    the name adds to the data but for a few standard deviations. What acts at the same place and has
    more evidence in its best wording than the name in its own is one at once. What acts at another
    place has to come close in the catalogue's wording, too: it is no other word for the same.
    """

    def failures(self, named: NamedModel) -> Iterator[Failure]:
        """See `VerdictCheck.failures`."""
        names = {one.effect.name for one in named.named}
        for one in named.named:
            odds = {n: v for n, v in _odds(named, one).items() if n not in names}
            if odds:
                yield Failure(
                    consequence=Consequence.INDISTINGUISHABLE,
                    sentence=(
                        f"these data do not tell {title(one.effect.name)} from"
                        f" {' or '.join(shortened([title(name) for name in odds]))}"
                    ),
                    effects=(one.effect.name,),
                    rivals=tuple(odds),
                    odds=tuple(odds.values()),
                )


def _odds(named: NamedModel, one: Choice) -> dict[str, float]:
    """Return the probability of each rival over the name's; above 1 where wordings are clear."""
    every = [
        c for c in one.ranking if c.known and (_same_place(c, one) or explains_as_much(c, one))
    ]
    effects = [c.score.candidate.effect for c in every]
    found = evidence(one.before, named.log_sigma, [e for e in effects if e is not None])
    own = next((c for c in every if c.name == one.effect.name), None)
    result = {}
    for rival in every:
        if rival is own:
            continue
        ahead = rival.ln_bayes_factor - (
            one.ln_bayes_factor if own is None else own.ln_bayes_factor
        )
        ahead = min(ahead, 0.0)
        if own is not None and {own.name, rival.name} <= found.keys():
            in_words = found[rival.name] - found[own.name]
            ahead = max(ahead, in_words if in_words > EQUAL_EVIDENCE_LN else min(in_words, 0.0))
        explains_more = ahead > 0.0 and _same_place(rival, one)
        if explains_more or (ahead > -reach(rival) and _imitates(named, one, rival)):
            result[rival.name] = float(np.exp(ahead / EVIDENCE_TEMPERATURE))
    return result


def reach(rival: RankedCandidate) -> float:
    """Return how far (ln) a rival may be behind.

    What says more than a name, with evidence against all that it says more, is that name.
    """
    effect = rival.score.candidate.effect
    more = 0 if effect is None else effect.claims - 1
    return FURTHER_NAME_LN if more else NEIGHBOUR_EVIDENCE_LN


def _same_place(rival: RankedCandidate, one: Choice) -> bool:
    where = rival.score.candidate.location
    return where == one.effect.location and not location(where).in_time


def explains_as_much(rival: RankedCandidate, one: Choice) -> bool:
    """Return whether what acts at another place explains about as much."""
    places = (rival.score.candidate.location, one.effect.location)
    close = rival.ln_bayes_factor > one.ln_bayes_factor - NEIGHBOUR_EVIDENCE_LN
    return close and not any(location(where).in_time for where in places)


def _imitates(named: NamedModel, one: Choice, rival: RankedCandidate) -> bool:
    """Return whether a rival in the name's place leaves too little of it to be seen."""
    fitted, effect = named.fitted, rival.score.candidate.effect
    if effect is None:
        return False
    index = next(i for i, f in enumerate(fitted.found) if f.effect.name == one.effect.name)
    forward, span = fitted.problem.forward, fitted.spans[index]
    whole = np.zeros(forward.row_index.size)
    for c, step in steps_of(fitted, index):
        whole += forward.rows_of(c, fitted.linear.states[c], step)
    keep = np.setdiff1d(np.arange(fitted.linear.columns.shape[1]), np.arange(span.start, span.stop))
    linear = with_only(fitted.linear, keep)
    projected = Projected.of(forward, linear, weigh(linear.data, fitted.solution.log_sigma))
    size = max(rival.score.scale, abs(rival.score.amplitude))
    every = [shape for shapes in wordings(one.before, effect) for shape in shapes]
    return any(_left(forward, projected, whole, s, size) < SEPARATION_SIGMA**2 for s in every)


def _left(
    forward: ForwardModel, projected: Projected, whole: FloatArray, shape: Candidate, size: float
) -> float:
    """Return the squares of a contribution that a shape of about this size leaves."""
    A, _ = projected.normal(forward, np.concatenate([whole[:, None], shape.columns], axis=1))
    inner = A[1:, 1:] + np.diag(np.full(shape.columns.shape[1], size**-2.0))
    return float(A[0, 0] - A[0, 1:] @ np.linalg.solve(inner, A[1:, 0]))


CHECK = Neighbours(
    name="neighbours",
    meaning="the data tell each name from others that explain about as much",
    order=26,
)
