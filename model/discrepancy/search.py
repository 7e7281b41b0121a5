"""Forward search: which candidate explains what is left, is it worth it, and what is left then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from model.discrepancy.form_share import form_share
from model.discrepancy.left_out import predictive_gains
from model.discrepancy.outliers import numbers_of, outlier_candidates, without
from model.discrepancy.scatter import ASSUMED
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
from model.discrepancy.tolerance import Found, whole_step
from model.effects.interface import Effect
from model.measurements import FloatArray, ModelError
from model.noise import Solution, weigh

CONTENDERS = 8  # candidates whose evidence is worked out with the noise beside them
CLOSE = 0.25  # contenders that are refined: those with so much less evidence, relative,
CLOSE_LEAST = 10.0  # ... or absolute
ALIKE = 2.0  # ln of the Bayes factor within which two explanations are about as good
SHAPES = 2  # other shapes of an effect, about as good, that are refined, too
REFINED = 4
MOST_OUTLIERS = 2
STUCK = 0.2  # share that says that the size may have been found at the wrong place
STRAINED = 4.0  # times the usual scatter that says so, too
STRICT = 0.1  # of the tolerance of a form, where its size is looked for first
INSIDE = 0.9  # of its bounds that a size may have to begin with
MOST_FORM = 0.75  # share of an effect that may be deviation: beyond it is the effect in name only
FURTHER = 1.5  # ln of the Bayes factor by which all but the first effect must exceed the threshold
PASSENGER = 0.08  # size against the effects found before, below which it may be their form


@dataclass(frozen=True)
class Contender:
    """A candidate with its evidence."""

    score: Score
    gain: float  # ln of the Bayes factor against the present model
    solution: Solution | None = None
    fitted: Fitted | None = None  # where it was refined
    shapes: tuple[Score, ...] = ()  # others of the same effect that explain about as much

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
    inside = {f.effect.name for f in fitted.found}
    every = candidates(fitted, [e for e in effects if e.name not in inside])
    if slots:
        every += unknowns(fitted)
    every += outlier_candidates(fitted)
    scores = _by_name(fitted, every, fitted.solution)
    best = {name: found[0] for name, found in scores.items()}
    usual = _best(fitted, every, _usual_scatter(fitted))
    hidden = [n for n in usual if not n.startswith("outlier:")][:CONTENDERS]
    result, tried = [], 0
    for name, one in {**best, **{n: usual[n] for n in hidden if n not in best}}.items():
        outlier = one.candidate.slot == "outlier"
        promising = tried < CONTENDERS and one.log_bayes > (3.0 if outlier else -0.5)
        if not promising and name not in hidden:
            result.append(Contender(one, one.log_bayes))
            continue
        tried += promising and not outlier
        looks = [one]
        if name in hidden and not _alike(one, usual[name]):
            looks.append(usual[name])
        both = [(*rescored(fitted, look), look) for look in looks]
        gain, solution, chosen = max(both, key=lambda item: item[0])
        shapes = [s for s in scores.get(name, [])[1:] if s.log_bayes > one.log_bayes - ALIKE]
        shapes = shapes[:SHAPES] if _bends(one) else []
        result.append(Contender(chosen, gain, solution, shapes=tuple(shapes)))
    result.sort(key=lambda c: -c.gain)
    return result


def _best(fitted: Fitted, every: Sequence[Candidate], solution: Solution) -> dict[str, Score]:
    """The best score of each name, at given scatter; best first."""
    return {name: found[0] for name, found in _by_name(fitted, every, solution).items()}


def _by_name(
    fitted: Fitted, every: Sequence[Candidate], solution: Solution
) -> dict[str, list[Score]]:
    """The scores of all shapes of each name, at given scatter; best first."""
    study = fitted.problem.study
    projected = Projected.of(study, fitted.linear, solution)
    scores = [s for s in (score(study, projected, c) for c in every) if allowed(s)]
    scores.sort(key=lambda s: -s.log_bayes)
    result: dict[str, list[Score]] = {}
    for one in scores:
        result.setdefault(one.candidate.name, []).append(one)
    return result


def _bends(one: Score) -> bool:
    """Whether it changes the beam, so that a straight line may not do."""
    effect = one.candidate.effect
    return effect is not None and effect.slot != "time" and type(effect).beam is not Effect.beam


def _alike(one: Score, other: Score) -> bool:
    """Whether they are the same columns of the same scale."""
    return one.candidate is other.candidate and one.scale == other.scale


def _usual_scatter(fitted: Fitted) -> Solution:
    """The same fit with no more scatter than is usual: what acts in every set-up hides in it."""
    least = np.minimum(fitted.solution.log_sigma, fitted.problem.guess)
    return weigh(fitted.linear.data, least)


def refined(fitted: Fitted, contender: Contender) -> Contender:
    """With the effect in the model, its values fitted and everything linearised there.

    Which of several shapes it has is told by fits: a straight line can hardly tell them apart.
    """
    known = None if contender.solution is None else contender.solution.log_sigma
    result = contender
    for one in (contender.score, *contender.shapes):
        first = _found(fitted, one, one.amplitude)
        result = _better(fitted, result, one, _settled(fitted, first, known))
    return result


def _refined_again(fitted: Fitted, contender: Contender) -> Contender:
    """From another beginning: a straight line from where the effect is absent may lead nowhere.

    It begins at a usual size or where it leads with the usual scatter, and lets nothing hide in
    scatter or form.
    """
    one = contender.score
    usual = _best(fitted, [one.candidate], _usual_scatter(fitted)).get(contender.name)
    size = 1.0 if usual is None else usual.amplitude
    size = float(np.copysign(max(1.0, abs(size)), size))
    begin = _found(fitted, one, size)
    return _better(fitted, contender, one, _settled(fitted, begin, None, strictly=True))


def _better(fitted: Fitted, contender: Contender, one: Score, other: Fitted | None) -> Contender:
    """The contender, or with this shape and fit where they are better than what it has."""
    best = contender.fitted
    if other is None or (best is not None and best.deviance <= other.deviance):
        return contender
    # its size was chosen from several, as in `score`
    gain = 0.5 * (fitted.deviance - other.deviance) - float(np.log(len(one.candidate.sizes)))
    return replace(contender, score=one, gain=gain, fitted=other)


def _found(fitted: Fitted, one: Score, amplitude: float) -> Found:
    """A scored effect at a multiple of its own size."""
    effect = one.candidate.effect
    if effect is None:
        raise TypeError(f"{one.candidate.name} is no effect of the catalogue")
    width = max(one.scale, 2.0 * abs(one.amplitude), 2.0 * abs(amplitude))
    return Found(effect, _begun(fitted, effect, one.candidate, amplitude), width)


def _begun(
    fitted: Fitted, effect: Effect, candidate: Candidate, amplitude: float
) -> dict[str, dict[str, float]]:
    """Its values at a multiple of its own size, within bounds; alike in all configurations."""
    size, values = effect.size, unit_values(effect, candidate.values, amplitude)
    if not (size.tried or size.log):
        low, high = INSIDE * size.low, INSIDE * size.high
        values[size.name] = float(np.clip(values[size.name], low, high))
    return {name: dict(values) for name in fitted.problem.study.names}


def _strained(fitted: Fitted) -> bool:
    """Whether set-ups seem to differ by much more than is usual."""
    times = fitted.solution.log_sigma - fitted.problem.guess
    return bool(np.max(times[: len(ASSUMED)]) > np.log(STRAINED))


def _settled(
    fitted: Fitted, one: Found, log_sigma: FloatArray | None, strictly: bool = False
) -> Fitted | None:
    """A model with one more effect, from this scatter on; None where it does not settle.

    `strictly`: the values are found in the catalogue's form before it may differ.
    """
    problem, theta, found = fitted.problem, fitted.theta, (*fitted.found, one)
    try:
        if strictly:
            strict = settle(problem, theta, found, log_sigma, STRICT)
            theta, found, log_sigma = strict.theta, strict.found, strict.solution.log_sigma
        return settle(problem, theta, found, log_sigma)
    except (ModelError, np.linalg.LinAlgError):
        return None


def refine_best(fitted: Fitted, ranking: list[Contender]) -> list[Contender]:
    """The effects of the catalogue that are close to the best one, refined; best first."""
    known = [c for c in ranking if c.known]
    if not known:
        return ranking
    top = known[0].gain
    least = top - max(CLOSE_LEAST, CLOSE * top)
    chosen = [c for c in known if c.gain >= least][:REFINED]
    done = {c.name: refined(fitted, c) for c in chosen}
    for name in _promising(fitted, list(done.values())):
        if _doubtful(done[name]):
            done[name] = _refined_again(fitted, done[name])
    rest = [c for c in ranking if c.name not in done]
    return sorted([*done.values(), *rest], key=lambda c: -c.gain)


def _promising(fitted: Fitted, done: list[Contender]) -> set[str]:
    """The one that explains most, and the one that would with the usual scatter."""
    usual = _best(fitted, [c.score.candidate for c in done], _usual_scatter(fitted))
    return {max(done, key=lambda c: c.gain).name, *list(usual)[:1]}


def _doubtful(contender: Contender) -> bool:
    """Whether its size may have been found at the wrong place."""
    best = contender.fitted
    return best is None or form_share(best, -1) > STUCK or _strained(best)


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
    while len(outcome.turns) < most + 1:
        turn = Turn(fitted, rank(fitted, effects))
        if not turn.ranking or turn.ranking[0].gain < threshold:
            outcome.turns.append(turn)
            break
        top, first = turn.ranking[0], turn.ranking[0].score.candidate
        sure = top.gain >= threshold + FURTHER
        if first.slot == "outlier" and sure and rounds_of_outliers < MOST_OUTLIERS:
            rounds_of_outliers += 1
            fitted = _left_out(outcome, fitted, numbers_of(first.name))
            continue
        outcome.turns.append(turn)
        turn.ranking = refine_best(fitted, turn.ranking)
        turn.chosen = _worth(turn, threshold) if len(outcome.turns) <= most else None
        if turn.chosen is None or turn.chosen.fitted is None:
            break
        fitted = turn.chosen.fitted
    outcome.final = fitted
    return outcome


def _left_out(outcome: Outcome, fitted: Fitted, numbers: list[int]) -> Fitted:
    """The model without these conditions; the base is fitted without them, too."""
    outcome.outliers += numbers
    problem, base = without(fitted.problem, numbers), outcome.base
    again = settle(problem, fitted.theta, fitted.found)
    nothing_new = len(fitted.found) == len(base.found)
    outcome.base = again if nothing_new else settle(problem, base.theta, base.found)
    return again


def apart(fitted: Fitted, contender: Contender) -> float:
    """Evidence of a further effect where each number may be off by some of what the others do.

    What is small against them everywhere may be what is left of their own form.
    """
    if not fitted.found:
        return contender.gain
    study, data = fitted.problem.study, fitted.linear.data
    # with the usual scatter, in which nothing hides
    usual = np.minimum(fitted.solution.log_sigma, fitted.problem.guess)
    doubt = study.layout.pad((PASSENGER * _rows(fitted)) ** 2)
    worth = []
    for one in (data, replace(data, fixed=data.fixed + doubt)):
        projected = Projected.of(study, fitted.linear, weigh(one, usual))
        worth.append(score(study, projected, contender.score.candidate).log_bayes)
    certain, doubted = worth
    kept = float(np.clip(doubted / certain, 0.0, 1.0)) if certain > 0.0 else 1.0
    return kept * contender.gain


def _rows(fitted: Fitted) -> FloatArray:
    """What all effects of a model do to the rows, (N,)."""
    study, active = fitted.problem.study, fitted.active
    rows = np.zeros(study.layout.size)
    for one in active:
        others = tuple(a for a in active if a is not one)
        for c, state in enumerate(fitted.linear.states):
            if study.names[c] in one.values:
                step = whole_step(study, c, state, state.base, others, one)
                rows += np.abs(study.rows_of(c, state, step))
    return rows


def _worth(turn: Turn, threshold: float) -> Contender | None:
    """The best effect of the catalogue whose form is in the data, if they ask for it."""
    threshold += FURTHER if turn.before.found else 0.0
    rest = _rest_of_forms(turn)
    for one in turn.ranking:
        if not one.known or one.fitted is None:
            continue
        worth, share = apart(turn.before, one), form_share(one.fitted, -1)
        # beside others a deviation may be what is left of theirs: then the form itself must count
        itself = (1.0 - share) * worth if turn.before.found else 0.0
        if share > MOST_FORM and itself < threshold:
            continue
        asked = min(one.gain, worth) >= threshold and one.gain > rest - ALIKE
        return one if asked and supported(turn.before, one.fitted) else None
    return None


def _rest_of_forms(turn: Turn) -> float:
    """What a free form explains in the slot of an effect before: more of that one's form."""
    slots = {f"unknown:{f.effect.slot}" for f in turn.before.found}
    return max((c.gain for c in turn.ranking if c.name in slots), default=-np.inf)
