"""Fits the weights and contents of `model.discrepancy.answers.calibrated_answers`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from benchmarks.worlds.cases import SHARES
from benchmarks.worlds.right_answers import Labelled
from model.discrepancy.answers.calibrated_answers import (
    REPORTED,
    CalibratedAnswers,
    likelier,
    reported,
)
from model.discrepancy.answers.choice_set import ATTRIBUTES
from model.measurements import FloatArray

COVERAGE = 0.95
LEAST_CONTENT = 0.9  # what is less probable than that never stands alone
ROUNDING = 1e-9
# prior precisions of a weight, over the mean square of its attribute where that is not 0; tried
RIDGES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
LEAST_PROBABILITY = 1e-4  # that a single question is judged by
NAMES = tuple(ATTRIBUTES)
# attributes that can only speak for an answer, or against it, whatever a few cases say
FOR = {
    "first", "considered", "votes", "unknown_considered", "unknown_ahead", "unknown_ahead_share",
    "unexplained", "unexplained_share", "scatter", "unknown_failed", "nothing_considered",
}  # fmt: skip
AGAINST = {
    "behind", "behind_share", "not_fitted", "form_share", "large", "freedom", "beside", "failed",
    "misfit", "uneven", "nothing_gain", "nothing_apart",
}  # fmt: skip


def weights(questions: Sequence[Labelled], ridge: float) -> dict[str, float]:
    """Return the most likely weights with a ridge, of the sign that each can have.

    Families count as they do in the benchmark. Questions whose right answers are not among the
    alternatives tell nothing of them.
    """
    use = [q for q in questions if q.right & {a.name for a in q.asked.alternatives}]
    tables = [np.array([[a.attributes.get(k, 0.0) for k in NAMES] for a in q.asked.alternatives])
              for q in use]  # fmt: skip
    right = [np.array([a.name in q.right for a in q.asked.alternatives]) for q in use]
    each = _shares(use)
    every = np.concatenate(tables)
    scale = np.sqrt(np.sum(every**2, axis=0) / np.maximum(np.sum(every != 0.0, axis=0), 1))
    scale = np.where(scale > 0.0, scale, 1.0)

    def loss(w: FloatArray) -> tuple[float, FloatArray]:
        value, slope = 0.5 * ridge * float(w @ w), ridge * w
        for X, good, count in zip(tables, right, each, strict=True):
            u = (X / scale) @ w
            all_p = np.exp(u - np.logaddexp.reduce(u))
            own = np.where(good, u, -np.inf)
            own_p = np.exp(own - np.logaddexp.reduce(own))
            value += count * float(np.logaddexp.reduce(u) - np.logaddexp.reduce(own))
            slope = slope + count * ((all_p - own_p) @ (X / scale))
        return value, slope

    bounds = [(0.0 if k in FOR else None, 0.0 if k in AGAINST else None) for k in NAMES]
    found = minimize(loss, np.zeros(len(NAMES)), jac=True, method="L-BFGS-B", bounds=bounds)
    return dict(zip(NAMES, (found.x / scale).tolist(), strict=True))


def _shares(questions: Sequence[Labelled]) -> FloatArray:
    """Return how much each question counts, so that families count as in the benchmark; mean 1."""
    counts = Counter(q.family for q in questions)
    each = np.array([SHARES[q.family] / counts[q.family] for q in questions])
    return each / np.mean(each) if len(each) else each


def likelier_than_right(one: Labelled, answers: CalibratedAnswers) -> float:
    """Return the probability of all answers before the first right one; infinite: there is none."""
    before = likelier(answers.probabilities(one.asked))
    return min(before.get(name, np.inf) for name in one.right)


def content(found: FloatArray, each: FloatArray, coverage: float = COVERAGE) -> float:
    """Return the smallest value that a share `coverage` of further ones does not exceed.

    `each`: how much each value counts. Where all count alike it is the k-th smallest of n, with k
    the next whole number above coverage (n + 1); 1 where n is too small (Vovk, Gammerman and Shafer
    2005, Algorithmic Learning in a Random World; with weights Tibshirani et al. 2019, Adv. Neural
    Inf. Process. Syst. 32, the next one counting as much as any).
    """
    if not len(found):
        return 1.0
    order = np.argsort(found)
    below = np.cumsum(each[order])
    enough = below >= coverage * (below[-1] + np.max(each)) * (1.0 - ROUNDING)
    return float(min(found[order[np.argmax(enough)]], 1.0)) if np.any(enough) else 1.0


def content_in_each(found: FloatArray, each: FloatArray, worlds: Sequence[str]) -> float:
    """Return the content with which sets hold the right answer in `COVERAGE` of further questions.

    And of the questions of each world: one that is unlike the others must not be averaged away.
    """
    of, whole = np.array(worlds), content(found, each)
    for world in dict.fromkeys(worlds):
        own = of == world
        order = np.argsort(found[own])
        below = np.cumsum(each[own][order])
        enough = below >= COVERAGE * below[-1] * (1.0 - ROUNDING)
        whole = max(whole, float(min(found[own][order][np.argmax(enough)], 1.0)))
    return whole


def in_other_worlds(questions: Sequence[Labelled], ridge: float) -> list[CalibratedAnswers]:
    """Return for each question answers whose weights were fitted to the other worlds only."""
    all_in = dict.fromkeys(REPORTED, 1.0)
    of = {
        world: CalibratedAnswers(weights([q for q in questions if q.world != world], ridge), all_in)
        for world in {q.world for q in questions}
    }
    return [of[q.world] for q in questions]


def log_loss(questions: Sequence[Labelled], answers: Sequence[CalibratedAnswers]) -> float:
    """Return the mean of -ln of the probability of what is right, each question by its own."""
    found = [(q, one.probabilities(q.asked)) for q, one in zip(questions, answers, strict=True)]
    right = [sum(chances.get(name, 0.0) for name in q.right) for q, chances in found]
    return float(-np.mean(_shares(questions) * np.log(np.maximum(right, LEAST_PROBABILITY))))


@dataclass(frozen=True)
class Fitted:
    """What was fitted, and how well it does in worlds that weights were not fitted to."""

    answers: CalibratedAnswers
    ridge: float
    log_loss: float


def fitted(questions: Sequence[Labelled]) -> Fitted:
    """Return weights from all questions, contents from worlds that weights were not fitted to.

    Contents are those that the worst of these worlds asks for.

    The ridge is that with which probabilities do best in such worlds.
    """
    foreign = {ridge: in_other_worlds(questions, ridge) for ridge in RIDGES}
    losses = {ridge: log_loss(questions, answers) for ridge, answers in foreign.items()}
    ridge = min(losses, key=lambda one: losses[one])
    before = np.array([
        likelier_than_right(q, one) for q, one in zip(questions, foreign[ridge], strict=True)
    ])  # fmt: skip
    of, each = np.array([reported(q.asked) for q in questions]), _shares(questions)
    worlds = np.array([q.world for q in questions])
    contents = {
        what: max(content_in_each(before[own], each[own], worlds[own].tolist()), LEAST_CONTENT)
        for what in REPORTED
        for own in [of == what]
    }
    return Fitted(CalibratedAnswers(weights(questions, ridge), contents), ridge, losses[ridge])
