"""Posterior probabilities of effects, and the effects each may be confused with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.criticism.image_noise import with_usual_noise
from model.discrepancy.search.beside_others import evidence_beside, evidence_beside_at_usual_noise
from model.discrepancy.search.evidence import Score
from model.discrepancy.search.forward_selection import SearchResult, SelectionStep
from model.discrepancy.search.nonparametric_terms import is_nonparametric
from model.discrepancy.search.ranking import RankedCandidate, rank
from model.discrepancy.search.refinement.best_candidates import refine_best
from model.discrepancy.search.refinement.fits import settled
from model.discrepancy.thresholds import (
    CERTAIN_PROBABILITY,
    EVIDENCE_TEMPERATURE,
    FURTHER_EFFECT_LN,
    NEGLIGIBLE_PROBABILITY,
)
from model.discrepancy.verdict.result import ChosenValue
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model import unsettled
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.model_state import Found
from model.locations import location


@dataclass(frozen=True, kw_only=True)
class Choice:
    """A named effect with its alternatives."""

    effect: Effect
    confidence: float  # posterior by the evidence alone
    ln_bayes_factor: float
    of_location: float  # posterior of all effects of its location
    before: MixedModelFit  # the model without it, the other names in place
    ranking: Sequence[RankedCandidate]  # of what could be added to that, best first
    tried: tuple[MixedModelFit, ...] = ()  # fits of its shapes
    compared: tuple[Score, ...] = ()  # all of its shapes, linearised


def posterior(ranking: Sequence[RankedCandidate]) -> dict[str, float]:
    """Of the catalogue's effects in a ranking, given that one of them is it."""
    known = [c for c in ranking if c.known]
    if not known:
        return {}
    ln_bayes_factors = np.array([c.ln_bayes_factor for c in known]) / EVIDENCE_TEMPERATURE
    weights = np.exp(ln_bayes_factors - np.max(ln_bayes_factors))
    return dict(zip((c.name for c in known), (weights / weights.sum()).tolist(), strict=True))


def choice(
    chosen: RankedCandidate, ranking: Sequence[RankedCandidate], before: MixedModelFit
) -> Choice:
    """Return the choice from a ranking, with its posterior probability."""
    effect = chosen.score.candidate.effect
    if effect is None:
        raise TypeError(f"{chosen.name} is no effect of the catalogue")
    chances = posterior(ranking)
    own = chances.get(chosen.name, 0.0)
    alike = {c.name for c in ranking if c.known and c.score.candidate.location == effect.location}
    of_location = sum(p for n, p in chances.items() if n in alike)
    return Choice(
        effect=effect,
        confidence=own,
        ln_bayes_factor=chosen.ln_bayes_factor,
        of_location=of_location,
        before=before,
        ranking=ranking,
        tried=chosen.tried,
        compared=chosen.compared,
    )


def chosen_values(one: Choice, found: Found) -> dict[str, ChosenValue]:
    """Return the values of an effect that are chosen among several, given that it is this effect.

    The fits of several values decide; where only one was worth fitting, the linearised scores do.
    """
    values = next(iter(found.values.values()))
    fits = [(_own(f), -0.5 * f.deviance) for f in one.tried]
    scores = [(dict(s.candidate.values), s.log_bayes) for s in one.compared]
    result = {}
    for parameter in one.effect.choices:
        name, value = parameter.name, float(values[parameter.name])
        several = len({v[name] for v, _ in fits}) > 1
        chances = _chances(fits if several else scores, name)
        if value in chances:
            meanings = {other: parameter.meaning_of(other) for other in chances}
            result[name] = ChosenValue(
                value=value,
                meaning=meanings[value],
                probability=chances[value],
                alternatives=tuple(
                    (meanings[other], chance)
                    for other, chance in sorted(chances.items(), key=lambda item: -item[1])
                    if other != value and chance > NEGLIGIBLE_PROBABILITY
                ),
            )
    return result


def _own(fitted: MixedModelFit) -> Mapping[str, float]:
    """Return the values of the effect that was added last."""
    return next(iter(fitted.found[-1].values.values()))


def _chances(
    compared: Sequence[tuple[Mapping[str, float], float]], name: str
) -> dict[float, float]:
    """Return the posterior probability of each value, by the best that has it."""
    best: dict[float, float] = {}
    for values, evidence in compared:
        if name in values:
            value = float(values[name])
            best[value] = max(evidence, best.get(value, -np.inf))
    if not best:
        return {}
    ln_bayes_factors = np.array(list(best.values())) / EVIDENCE_TEMPERATURE
    weights = np.exp(ln_bayes_factors - np.max(ln_bayes_factors))
    return dict(zip(best, (weights / weights.sum()).tolist(), strict=True))


def choices(
    outcome: SearchResult, effects: Sequence[Effect], threshold: float, rests: bool = False
) -> tuple[list[Choice], MixedModelFit]:
    """Return every effect that was found, each against its alternatives with the others in place.

    An effect that the others make superfluous is taken out again, and so is, unless `rests`, what
    is rather left of another one's form; what the model had before the search stays.
    """
    steps = [t for t in outcome.steps if t.chosen is not None]
    final, first = outcome.final, len(outcome.base.found)
    result = []
    for i, step in enumerate(steps):
        if step.chosen is None:
            continue
        if i == len(steps) - 1:
            result.append(choice(step.chosen, step.ranking, step.before))
            continue
        without = _without(final, first + i)
        ranking = refine_best(without, rank(without, effects, locations=False), final)
        own = next((c for c in ranking if c.name == step.chosen.name), step.chosen)
        ln_bayes_factor = 0.5 * (without.deviance - final.deviance)
        if min(ln_bayes_factor, evidence_beside(without, own)) < threshold + FURTHER_EFFECT_LN:
            shorter = SearchResult(outcome.base, steps[:i] + steps[i + 1 :], without)
            return choices(shorter, effects, threshold, rests)
        result.append(choice(own, ranking if own is not step.chosen else step.ranking, without))
    left = None if rests else rest_of_another(result)
    if left is None:
        return result, final
    without = _without(final, first + left)
    shorter = SearchResult(outcome.base, steps[:left] + steps[left + 1 :], without)
    return choices(shorter, effects, threshold)


def _without(final: MixedModelFit, place: int) -> MixedModelFit:
    """Return the model fitted without one of its effects; raise `ModelError` where it is not.

    It is fitted once: the choices are made again where what was taken for a rest is more than that.
    """
    others = tuple(one for j, one in enumerate(final.found) if j != place)
    found = settled(final, final.theta, others, final.solution.log_sigma)
    if found is None:
        raise unsettled()
    return found


def with_shapes(fitted: MixedModelFit, named: Sequence[Choice]) -> MixedModelFit:
    """Return the model with uncertainties that hold the other shapes of each effect, too.

    A shape that explains as much may have other values.
    """
    tried = {one.effect.name: one.tried for one in named if len(one.tried) > 1}
    if not tried:
        return fitted
    found = [_mixed(f, tried[f.effect.name]) if f.effect.name in tried else f for f in fitted.found]
    return replace(fitted, found=tuple(found))


def _mixed(one: Found, tried: Sequence[MixedModelFit]) -> Found:
    """With the scatter of the values of all fits about the best, as likely as they explain."""
    deviance = np.array([f.deviance for f in tried])
    best = tried[int(np.argmin(deviance))].found[-1].values
    weights = np.exp(0.5 * (np.min(deviance) - deviance) / EVIDENCE_TEMPERATURE)
    weights /= weights.sum()

    logs = {parameter.name for parameter in one.effect.parameters if parameter.log}

    def wider(name: str, parameter: str, sigma: float) -> float:
        values = np.array([f.found[-1].values[name][parameter] for f in tried])
        away = values - best[name][parameter]
        if parameter in logs:
            away = one.values[name][parameter] * np.log(values / best[name][parameter])
        return float(np.sqrt(sigma**2 + weights @ np.square(away)))

    sigma = {
        name: {parameter: wider(name, parameter, size) for parameter, size in own.items()}
        for name, own in one.sigma.items()
    }
    return replace(one, sigma=sigma)


def rest_of_another(named: Sequence[Choice]) -> int | None:
    """Return place of an effect that is rather what is left of a stronger one's form.

    Forms differ in more ways than are tolerated. What several effects of several locations explain
    as well is such a rest, and so is a change in time beside another one if it is no clear name.
    """
    strongest = max(named, key=lambda one: one.ln_bayes_factor, default=None)
    for i, one in sorted(enumerate(named), key=lambda item: item[1].ln_bayes_factor):
        if one is strongest or one.confidence >= CERTAIN_PROBABILITY:
            continue
        stronger = [other for other in named if other.ln_bayes_factor > one.ln_bayes_factor]
        in_time = _in_time(one) and any(_in_time(other) for other in stronger)
        if in_time or one.of_location < CERTAIN_PROBABILITY:
            return i
    return None


def _in_time(one: Choice) -> bool:
    return location(one.effect.location).in_time


@dataclass(frozen=True, kw_only=True)
class ResidualTerms:
    """The findings of nonparametric terms in the residual of a model."""

    ln_bayes_factor: float  # of the best free form on the final model
    total: float  # of the best free form on the base model, or of the catalogue's effects
    location: str  # of the best free form
    first: RankedCandidate  # the free form on the base model
    last: RankedCandidate | None  # the same on the final model
    ln_bayes_factor_beside: float  # the same beside what the names explain
    ranking: Sequence[RankedCandidate] = ()  # of everything, on the final model

    @property
    def share(self) -> float:
        """Of the excess that is left."""
        return max(self.ln_bayes_factor, 0.0) / max(self.total, 1e-9)

    def instead(
        self, hidden: Sequence[RankedCandidate], final: MixedModelFit, base: MixedModelFit
    ) -> ResidualTerms:
        """Return the same with what hides in noise as the nonparametric term, the first of them.

        They stand for those of their locations.
        """
        best, explained = hidden[0], 0.5 * (base.deviance - final.deviance)
        names = {one.name for one in hidden[1:]}
        others = [one for one in self.ranking if one.name not in names]
        return replace(
            self, ln_bayes_factor=best.ln_bayes_factor,
            total=max(self.total, explained + best.ln_bayes_factor),
            location=best.score.candidate.location, last=best,
            first=best if final is base else self.first,
            ln_bayes_factor_beside=evidence_beside_at_usual_noise(
                with_usual_noise(final, best), best
            ),
            ranking=sorted([*hidden, *others], key=lambda c: -c.ln_bayes_factor),
        )  # fmt: skip


def residual_terms(
    outcome: SearchResult, final: MixedModelFit, effects: Sequence[Effect]
) -> ResidualTerms | None:
    """Return how much free forms could still explain."""
    first = [c for c in outcome.steps[0].ranking if is_nonparametric(c.name)]
    if not first:
        return None
    best = max(first, key=lambda c: c.ln_bayes_factor)
    explained = 0.5 * (outcome.base.deviance - final.deviance) if final.found else 0.0
    ranked = (step for step in outcome.steps if step.before is final)
    same = next(ranked, None) or SelectionStep(final, rank(final, effects))
    last = [c for c in same.ranking if is_nonparametric(c.name)]
    best_on_final = max(last, key=lambda c: c.ln_bayes_factor, default=None)
    ln_bayes_factor = best_on_final.ln_bayes_factor if best_on_final is not None else 0.0
    total = max(best.ln_bayes_factor, explained + max(ln_bayes_factor, 0.0))
    beside = evidence_beside(final, best_on_final) if best_on_final is not None else 0.0
    return ResidualTerms(
        ln_bayes_factor=ln_bayes_factor,
        total=total,
        location=best.name.split(":")[1],
        first=best,
        last=best_on_final,
        ln_bayes_factor_beside=beside,
        ranking=same.ranking,
    )
