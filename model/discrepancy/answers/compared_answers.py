"""Make the choice sets of a verdict from a finished search."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN, Alternative, ChoiceSet
from model.discrepancy.answers.votes import votes
from model.discrepancy.criticism.check_result import Consequence
from model.discrepancy.criticism.criticise import Criticism
from model.discrepancy.criticism.families import Family, families, joined
from model.discrepancy.criticism.group_amplitudes import Group, group_amplitudes
from model.discrepancy.criticism.named_model import MOUNTING, NamedModel, limited_scatter
from model.discrepancy.search.beside_others import evidence_beside
from model.discrepancy.search.form_share import form_share
from model.discrepancy.search.forward_selection import SearchResult
from model.discrepancy.search.nonparametric_terms import is_nonparametric, unknowns
from model.discrepancy.search.ranking import RankedCandidate, best_scores
from model.discrepancy.thresholds import COMPARED_NAMES
from model.discrepancy.verdict.posterior import Choice, ResidualTerms
from model.identification.data.data_vector import Index
from model.identification.likelihood.mixed_model_fit import MixedModelFit

MOST_FAILURES = 3
LEAST_EVIDENCE_LN = 10.0  # a share of less says nothing
_AGAINST_NO_NAME = (
    Consequence.IMPROBABLE_AMPLITUDE, Consequence.INDISTINGUISHABLE, Consequence.REMARK
)  # fmt: skip
SURE_SIGMA, MOST_UNEVEN = 2.0, 2.0
_KINDS_OF_PART: tuple[Callable[[Family], str], ...] = (
    lambda f: f.quantity, lambda f: f.configuration, lambda f: f"{f.voltage_V:g} V",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class ComparedAnswers:
    """What search and checks say, as far as the answers are judged by it."""

    judged: NamedModel  # with the names of the search
    residual: ResidualTerms | None  # what nonparametric terms find beside them
    unknown: bool  # whether the search calls that unknown
    criticism: Criticism

    @property
    def outcome(self) -> SearchResult:
        """The search."""
        return self.judged.outcome

    @property
    def named(self) -> Sequence[Choice]:
        """What the search names."""
        return self.judged.named

    @property
    def known(self) -> MixedModelFit:
        """The model with these names."""
        return self.judged.fitted

    def choice_sets(self) -> tuple[ChoiceSet, ...]:
        """Return the choice set of each name, and the last one."""
        return (*map(self._of_name, self.named), self._of_rest())

    def _of_name(self, one: Choice) -> ChoiceSet:
        ranking = [c for c in one.ranking if not c.name.startswith("outlier:")]
        names = self._names(one.before, ranking, one.effect.name)
        free = _free_gain(one.before, ranking)
        failed = self._failed(one.effect.name)
        unknown = self._unknown(ranking, free, considered=False, failed=failed)
        worth = evidence_beside(one.before, ranking[0]) if ranking else 0.0
        nothing = _nothing(
            one.ln_bayes_factor, worth, further=len(self.named) > 1, considered=False
        )
        return ChoiceSet(one.effect.name, (*names, unknown, nothing))

    def _of_rest(self) -> ChoiceSet:
        """Return the answers to what else is not in the model."""
        ranking = self._last_ranking
        free = max((c.ln_bayes_factor for c in ranking if is_nonparametric(c.name)), default=0.0)
        best = ranking[0] if ranking else None
        nothing = _nothing(
            0.0 if best is None else best.ln_bayes_factor, self._worth(best),
            further=bool(self.named), considered=not self.unknown,
        )  # fmt: skip
        unknown = self._unknown(ranking, free, considered=self.unknown)
        considered = UNKNOWN if self.unknown else NOTHING
        return ChoiceSet(considered, (*self._names(self.known, ranking, ""), unknown, nothing))

    def _worth(self, best: RankedCandidate | None) -> float:
        """Return the evidence of what is best beside the names, these being uncertain."""
        if best is None:
            return 0.0
        hidden = self.judged.cell_noise if self.judged.plain is not None else None
        if self.residual is not None and hidden is not None and best is hidden.term:
            return self.residual.ln_bayes_factor_beside  # the model has it already
        return evidence_beside(self.known, best)

    @property
    def _last_ranking(self) -> Sequence[RankedCandidate]:
        """Everything that could be added to the model with the names, best first."""
        if self.residual is not None:
            return [c for c in self.residual.ranking if not c.name.startswith("outlier:")]
        return []

    def _names(
        self, before: MixedModelFit, ranking: Sequence[RankedCandidate], named: str
    ) -> list[Alternative]:
        known = sorted((c for c in ranking if c.known), key=lambda c: -c.ln_bayes_factor)
        asked = bool(named) or not self.named  # beside names that are in place no other is chosen
        chosen = votes(before, known, self.judged.log_sigma, named) if asked else {}
        some = known[:COMPARED_NAMES]
        some += [c for c in known[COMPARED_NAMES:] if c.name == named]
        return [self._name(c, known[0], named, chosen) for c in some]

    def _name(
        self, one: RankedCandidate, best: RankedCandidate, named: str, chosen: Mapping[str, float]
    ) -> Alternative:
        behind = best.ln_bayes_factor - one.ln_bayes_factor
        attributes = {
            "behind": float(np.log1p(behind)),
            "behind_share": behind / max(best.ln_bayes_factor, LEAST_EVIDENCE_LN),
            "first": float(one is best),
            "not_fitted": float(one.fitted is None),
            "form_share": 0.0 if one.fitted is None else form_share(one.fitted, -1),
            "votes": chosen.get(one.name, 0.0),
            "large": float(np.log10(max(abs(one.score.amplitude), 1.0))),
            "freedom": float(np.log(one.score.candidate.columns.shape[1])),
        }
        if one.name == named:
            attributes |= {
                "considered": 1.0,
                "beside": float(len(self.named) > 1),
                "failed": self._failed(named),
                "misfit": self._misfit,
                "uneven": self._uneven(named),
            }
        return Alternative(one.name, attributes)

    def _failed(self, name: str) -> float:
        against = [f for f in self.criticism.failures if f.consequence not in _AGAINST_NO_NAME]
        own = [f for f in against if not f.effects or name in f.effects]
        return float(min(len(own), MOST_FAILURES))

    def _unknown(
        self,
        ranking: Sequence[RankedCandidate],
        free: float,
        *,
        considered: bool,
        failed: float = 0.0,
    ) -> Alternative:
        best = max((c.ln_bayes_factor for c in ranking if c.known), default=0.0)
        # what the load cell's noise hid is in the model, and no part of a name's question
        there = self.residual is not None and (considered or self.judged.plain is None)
        beside, share = (
            (self.residual.ln_bayes_factor_beside, self.residual.share)
            if self.residual and there
            else (0.0, 0.0)
        )
        beside = max(beside, 0.0)
        attributes = {
            "unknown": 1.0,
            "unknown_ahead": _signed_log(free - best),
            "unknown_ahead_share": float(
                np.clip((free - best) / max(free, best, LEAST_EVIDENCE_LN), -1.0, 1.0)
            ),
            "unexplained": float(np.log1p(beside)),
            "unexplained_share": min(share, 1.0, beside / LEAST_EVIDENCE_LN),
            "scatter": self._scatter,
            "unknown_considered": float(considered),
            "unknown_failed": failed,
        }
        return Alternative(UNKNOWN, attributes)

    @cached_property
    def _misfit(self) -> float:
        """Ln of the largest chi^2 per left-out number of a quantity, the names in the model."""
        largest = 1.0
        for _, rows in _parts(self._families, lambda f: f.quantity):
            chi2, count = self.judged.predictive.chi2(rows)
            largest = max(largest, chi2 / max(count, 1))
        return float(np.log(largest))

    @cached_property
    def _families(self) -> list[Family]:
        return families(self.known, self.outcome.outliers)

    def _uneven(self, name: str) -> float:
        """Return how far a name's amplitude in a part of the data surely is from that in all."""
        place = next(i for i, f in enumerate(self.known.found) if f.effect.name == name)
        log_sigma, largest = limited_scatter(self.known), 0.0
        for kind in _KINDS_OF_PART:
            groups = [Group(*part) for part in _parts(self._families, kind)]
            for one in group_amplitudes(self.known, place, groups, log_sigma):
                largest = max(largest, abs(one.factor - 1.0) - SURE_SIGMA * one.sigma)
        return min(largest, MOST_UNEVEN)

    @cached_property
    def _scatter(self) -> float:
        """Ln of the largest random effect of a mounting over its usual size, at least 0."""
        problem = self.known.problem
        names = problem.noise.random_effects
        ratio = (self.known.solution.log_sigma - problem.guess)[: len(names)]
        return max([0.0, *(float(v) for n, v in zip(names, ratio, strict=True) if n in MOUNTING)])


def _parts(some: Sequence[Family], kind: Callable[[Family], str]) -> Iterator[tuple[str, Index]]:
    """Yield the rows of each part of the data of a kind, by its name."""
    for name in dict.fromkeys(map(kind, some)):
        yield name, joined([f for f in some if kind(f) == name])


def _nothing(gain: float, worth: float, *, further: bool, considered: bool) -> Alternative:
    return Alternative(
        NOTHING,
        {
            "nothing": 1.0,
            "nothing_further": float(further),
            "nothing_considered": float(considered),
            "nothing_gain": _signed_log(gain),
            "nothing_apart": _signed_log(worth),
        },
    )


def _free_gain(before: MixedModelFit, ranking: Sequence[RankedCandidate]) -> float:
    """Return the evidence of the best nonparametric term for the model without a name."""
    ranked = [c.ln_bayes_factor for c in ranking if is_nonparametric(c.name)]
    if ranked:
        return max(ranked)
    scores = best_scores(before, unknowns(before), before.solution)
    return max((one.log_bayes for one in scores.values()), default=0.0)


def _signed_log(value: float) -> float:
    return float(np.sign(value) * np.log1p(abs(value)))
