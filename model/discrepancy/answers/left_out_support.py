"""What left-out data say of the names that compete for one question, all other names in place.

Each competes beside what else is named: a second effect that is chosen without any of the positions
is as sure as a first one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from model.discrepancy.criticism.families import families, joined
from model.discrepancy.search.cross_validation import (
    position_groups,
    predictive_gains,
    scores_without,
)
from model.discrepancy.search.evidence import Candidate, Projected, Score, candidates, score
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import CROSS_VALIDATED_NAMES
from model.effects.interface import Effect
from model.identification.data.data_vector import Index
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray

VAGUE_SI = 1.0  # variance of rows that are not to count


@dataclass(frozen=True, kw_only=True)
class LeftOutSupport:
    """The names that compete, and the model without any of them."""

    before: MixedModelFit
    ranking: Sequence[RankedCandidate]  # of what could be added to it
    log_sigma: FloatArray  # scatter and noise beside all that is named
    considered: str = ""  # by the search

    @cached_property
    def votes(self) -> Mapping[str, float]:
        """Return the share of the positions without which each name explains most."""
        every = (scores_without(self._judge, self._pool, runs) for runs in self._positions)
        return _shares(every if self._pool else ())

    @cached_property
    def polarity_votes(self) -> Mapping[str, float]:
        """Return the share of the polarities without which each name explains most."""
        return _shares(self._without_polarities() if self._pool else ())

    @cached_property
    def left_out_gains(self) -> Mapping[str, FloatArray]:
        """Return by how much each fitted name makes each left-out position likelier (ln)."""
        return {
            one.name: predictive_gains(self.before, one.fitted)
            for one in self.ranking
            if one.known and one.fitted is not None
        }

    @cached_property
    def own_form(self) -> Mapping[str, float]:
        """Return the evidence of each name in the catalogue's form alone, over that in any."""
        free, strict = _best(self._scored(self._pool)), _best(self._scored(self._strict))
        return {
            name: float(np.clip(strict.get(name, 0.0) / value, 0.0, 1.0)) if value > 0.0 else 0.0
            for name, value in free.items()
        }

    @cached_property
    def _effects(self) -> list[Effect]:
        known = sorted((c for c in self.ranking if c.known), key=lambda c: -c.gain)
        some = [c for i, c in enumerate(known) if i < CROSS_VALIDATED_NAMES or self._own(c)]
        return [c.score.candidate.effect for c in some if c.score.candidate.effect is not None]

    def _own(self, one: RankedCandidate) -> bool:
        return one.name == self.considered

    @cached_property
    def _pool(self) -> list[Candidate]:
        return candidates(self.before, self._effects)

    @cached_property
    def _strict(self) -> list[Candidate]:
        return candidates(self.before, self._effects, tolerant=False)

    @cached_property
    def _judge(self) -> MixedModelFit:
        """Return the model with the noise beside all names: its own has taken up what they do."""
        return replace(self.before, solution=weigh(self.before.linear.data, self.log_sigma))

    @cached_property
    def _positions(self) -> list[Index]:
        return position_groups(self.before)

    def _scored(self, pool: Sequence[Candidate]) -> list[Score]:
        forward = self.before.problem.forward
        projected = Projected.of(forward, self.before.linear, self._judge.solution)
        return [score(forward, projected, one) for one in pool]

    def _without_polarities(self) -> Iterator[list[Score]]:
        forward, linear = self.before.problem.forward, self.before.linear
        every = families(self.before)
        for sign in (1.0, -1.0):
            rows = joined([f for f in every if sign * f.voltage_V > 0.0])
            if not len(rows):
                continue
            vague = np.zeros(forward.layout.size)
            vague[rows] = VAGUE_SI
            data = replace(linear.data, fixed=linear.data.fixed + forward.layout.pad(vague))
            projected = Projected.of(forward, linear, weigh(data, self.log_sigma))
            yield [score(forward, projected, one) for one in self._pool]


def _best(scores: Sequence[Score]) -> dict[str, float]:
    """Return the largest evidence of each name."""
    result: dict[str, float] = {}
    for one in scores:
        name = one.candidate.name
        result[name] = max(result.get(name, -np.inf), one.log_bayes)
    return result


def _shares(cases: Iterator[list[Score]] | Sequence[list[Score]]) -> dict[str, float]:
    """Return in which share of the cases each name has the most evidence."""
    chosen = Counter(max(_best(scores).items(), key=lambda item: item[1])[0] for scores in cases)
    return {name: times / chosen.total() for name, times in chosen.items()}
