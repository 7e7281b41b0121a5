"""From the search's turns to a verdict: what is named, how surely, and what it may be confused with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.discrepancy.score import Projected
from model.discrepancy.search import Contender, Outcome, Turn, rank, refine_best
from model.discrepancy.settle import Fitted, settle
from model.discrepancy.slots import unknowns
from model.effects.interface import Effect

TEMPER = 2.0  # evidence is not worth quite what it says: forms differ in ways nobody thought of
SURE = 0.02  # posterior below which an alternative is not mentioned
LEFT = 0.2  # share of the excess that may be left to a catalogue that is right
SLOT_MARGIN = 6.0  # ln of the Bayes factor by which a free form must be better than a name
CLASS_PRIOR = -3.0  # ln of the prior of a free form against a name's


@dataclass(frozen=True)
class Choice:
    """A named effect with what it was chosen from."""

    effect: Effect
    confidence: float
    alternatives: tuple[tuple[str, float], ...]  # name, posterior; only those worth mentioning
    gain: float


def posterior(ranking: Sequence[Contender]) -> dict[str, float]:
    """Of the names, given that one of them is it; free forms count as one more name each."""
    names, values = [], []
    for one in ranking:
        if one.name.startswith("outlier"):
            continue
        names.append(one.name)
        values.append(one.gain / TEMPER + (0.0 if one.known else CLASS_PRIOR))
    if not values:
        return {}
    weights = np.exp(np.array(values) - max(values))
    return dict(zip(names, (weights / weights.sum()).tolist(), strict=True))


def choice(turn: Turn) -> Choice:
    """What a turn chose, and how surely."""
    assert turn.chosen is not None and turn.chosen.score.candidate.effect is not None
    chances = posterior([c for c in turn.ranking if c.known])
    own = chances.get(turn.chosen.name, 0.0)
    others = sorted(
        ((n, p) for n, p in chances.items() if n != turn.chosen.name and p > SURE),
        key=lambda item: -item[1],
    )
    return Choice(turn.chosen.score.candidate.effect, own, tuple(others), turn.chosen.gain)


def choices(
    outcome: Outcome, effects: Sequence[Effect], threshold: float
) -> tuple[list[Choice], Fitted]:
    """Every effect of the final model, each against its alternatives with the others in place.

    An effect that the others make superfluous is taken out again.
    """
    turns = [t for t in outcome.turns if t.chosen is not None]
    final = outcome.final
    if len(turns) <= 1:
        return [choice(t) for t in turns], final
    result = []
    for i, one in enumerate(final.found):
        last = i == len(final.found) - 1
        if last:
            result.append(choice(turns[-1]))
            continue
        rest = tuple(f for j, f in enumerate(final.found) if j != i)
        without = settle(final.problem, final.theta, rest, final.solution.log_sigma)
        gain = 0.5 * (without.deviance - final.deviance)
        if gain < threshold:
            shorter = Outcome(outcome.base, turns[:i] + turns[i + 1 :], without)
            return choices(shorter, effects, threshold)
        ranking = refine_best(without, rank(without, effects, slots=False))
        own = next((c for c in ranking if c.name == one.effect.name), None)
        result.append(choice(Turn(without, ranking, own)) if own else choice(turns[i]))
    return result, final


@dataclass(frozen=True)
class Leftover:
    """What free forms find in what a model leaves."""

    gain: float  # of the best free form on the final model
    total: float  # of the best free form on the base model, or of the catalogue's effects
    slot: str  # of the best free form
    first: Contender  # the free form on the base model
    last: Contender | None  # the same on the final model

    @property
    def share(self) -> float:
        """Of the excess that is left."""
        return max(self.gain, 0.0) / max(self.total, 1e-9)


def leftover(outcome: Outcome, final: Fitted, effects: Sequence[Effect]) -> Leftover | None:
    """How much free forms could still explain."""
    first = [c for c in outcome.turns[0].ranking if c.name.startswith("unknown:")]
    if not first:
        return None
    best = max(first, key=lambda c: c.gain)
    explained = 0.5 * (outcome.base.deviance - final.deviance) if final.found else 0.0
    same = (
        outcome.turns[-1]
        if outcome.turns[-1].before is final
        else Turn(final, rank(final, effects))
    )
    last = [c for c in same.ranking if c.name.startswith("unknown:")]
    rest = max(last, key=lambda c: c.gain, default=None)
    gain = rest.gain if rest is not None else 0.0
    total = max(best.gain, explained + max(gain, 0.0))
    return Leftover(gain, total, best.name.split(":")[1], best, rest)


def projected(fitted: Fitted) -> Projected:
    """For scoring at a fitted model."""
    return Projected.of(fitted.problem.study, fitted.linear, fitted.solution)


__all__ = [
    "Choice",
    "Leftover",
    "choice",
    "choices",
    "leftover",
    "posterior",
    "projected",
    "unknowns",
]
