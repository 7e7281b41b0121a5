"""Forward search: which candidate explains what is left, is it worth it, and what is left then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from model.discrepancy.gaps import predictive_gains
from model.discrepancy.outliers import numbers_of, outlier_candidates, without
from model.discrepancy.score import (
    Candidate,
    Projected,
    Score,
    allowed,
    candidates,
    rescored,
    score,
    unit_values,
)
from model.discrepancy.settle import Fitted, Problem, settle
from model.discrepancy.slots import unknowns
from model.discrepancy.tolerance import Found
from model.effects.interface import Effect
from model.measurements import ModelError
from model.noise import Solution

CONTENDERS = 8  # candidates whose evidence is worked out with the noise beside them
CLOSE = 0.25  # contenders that are refined: those with so much less evidence, relative,
CLOSE_LEAST = 10.0  # ... or absolute
REFINED = 4
MOST_OUTLIERS = 2


@dataclass(frozen=True)
class Contender:
    """A candidate with its evidence."""

    score: Score
    gain: float  # ln of the Bayes factor against the present model
    solution: Solution | None = None
    fitted: Fitted | None = None  # where it was refined

    @property
    def name(self) -> str:
        """Of the effect, `unknown:SLOT`, or `outlier:NUMBER`."""
        return self.score.candidate.name

    @property
    def known(self) -> bool:
        """Whether it is an effect of the catalogue."""
        return self.score.candidate.effect is not None


@dataclass
class Turn:
    """One turn of the search."""

    before: Fitted
    ranking: list[Contender]
    chosen: Contender | None = None


@dataclass
class Outcome:
    """How the search went."""

    base: Fitted
    turns: list[Turn]
    final: Fitted
    outliers: list[int] = field(default_factory=list)  # numbers of conditions left out


def rank(fitted: Fitted, effects: Sequence[Effect], slots: bool = True) -> list[Contender]:
    """Everything that could be added, best first; the promising ones with the noise beside them."""
    study = fitted.problem.study
    inside = {f.effect.name for f in fitted.found}
    projected = Projected.of(study, fitted.linear, fitted.solution)
    every = candidates(fitted, [e for e in effects if e.name not in inside])
    if slots:
        every += unknowns(fitted)
    every += outlier_candidates(fitted)
    scores = [s for s in (score(study, projected, c) for c in every) if allowed(s)]
    scores.sort(key=lambda s: -s.log_bayes)
    best: dict[str, Score] = {}
    for one in scores:
        best.setdefault(one.candidate.name, one)
    result, tried = [], 0
    for one in best.values():
        outlier = one.candidate.slot == "outlier"
        if tried < CONTENDERS and one.log_bayes > (3.0 if outlier else -0.5):
            gain, solution = rescored(fitted, one)
            tried += not outlier
            result.append(Contender(one, gain, solution))
        else:
            result.append(Contender(one, one.log_bayes))
    result.sort(key=lambda c: -c.gain)
    return result


def refined(fitted: Fitted, contender: Contender) -> Contender:
    """With the effect in the model, its values fitted and everything linearised there."""
    candidate = contender.score.candidate
    assert candidate.effect is not None
    values = unit_values(candidate.effect, candidate.values, contender.score.amplitude)
    names = fitted.problem.study.names
    width = max(3.0, 2.0 * abs(contender.score.amplitude))
    one = Found(candidate.effect, {name: dict(values) for name in names}, width)
    try:
        best = settle(
            fitted.problem, fitted.theta, (*fitted.found, one),
            None if contender.solution is None else contender.solution.log_sigma,
        )  # fmt: skip
    except (ModelError, np.linalg.LinAlgError):
        return contender
    gain = 0.5 * (fitted.deviance - best.deviance)
    return replace(contender, gain=gain, fitted=best)


def refine_best(fitted: Fitted, ranking: list[Contender]) -> list[Contender]:
    """The effects of the catalogue that are close to the best one, refined; best first."""
    known = [c for c in ranking if c.known]
    if not known:
        return ranking
    top = known[0].gain
    least = top - max(CLOSE_LEAST, CLOSE * top)
    chosen = [c for c in known if c.gain >= least][:REFINED]
    done = [refined(fitted, c) for c in chosen]
    rest = [c for c in ranking if c not in chosen]
    return sorted([*done, *rest], key=lambda c: -c.gain)


def supported(before: Fitted, after: Fitted) -> bool:
    """Whether positions that are left out speak for the effect, not just a single one of them."""
    gains = predictive_gains(before, after)
    if len(gains) < 3:
        return True
    total = float(np.sum(gains))
    return total > 0.0 and total - float(np.max(gains)) > -0.1 * total


def search(
    problem: Problem,
    theta: FloatArray,
    effects: Sequence[Effect],
    threshold: float,
    most: int = 3,
    found: tuple[Found, ...] = (),
) -> Outcome:
    """Add effects while the data ask for them."""
    fitted = settle(problem, theta, found)
    outcome, rounds_of_outliers = Outcome(fitted, [], fitted), 0
    while len(outcome.turns) < most + MOST_OUTLIERS + 1:
        ranking = rank(fitted, effects)
        turn = Turn(fitted, ranking)
        outcome.turns.append(turn)
        if not ranking or ranking[0].gain < threshold:
            break
        outlier = ranking[0].score.candidate
        if outlier.slot == "outlier" and rounds_of_outliers < MOST_OUTLIERS:
            numbers = numbers_of(outlier.name)
            outcome.outliers += numbers
            rounds_of_outliers += 1
            fitted = settle(without(fitted.problem, numbers), fitted.theta, fitted.found)
            if not fitted.found:
                outcome.base = fitted
            outcome.turns.pop()
            continue
        turn.ranking = refine_best(fitted, ranking)
        best = next((c for c in turn.ranking if c.known), None)
        if best is None or best.gain < threshold or best.fitted is None:
            break
        if not supported(fitted, best.fitted):
            break
        if len(fitted.found) >= most:
            break
        turn.chosen = best
        fitted = best.fitted
    outcome.final = fitted
    return outcome


__all__ = ["Candidate", "Contender", "Outcome", "Turn", "rank", "refine_best", "refined", "search"]
