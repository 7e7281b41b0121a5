"""Fits the weights and contents of `model.discrepancy.answers.calibrated_answers`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from benchmarks.worlds.cases import SHARES
from benchmarks.worlds.right_answers import Labelled
from model.discrepancy.answers.calibrated_answers import (
    SAID,
    CalibratedAnswers,
    likelier,
    said,
)
from model.discrepancy.answers.choice_set import ATTRIBUTES
from model.measurements import FloatArray

COVERAGE = 0.95
LEAST_CONTENT = 0.95
ROUNDING = 1e-9
RIDGE = 0.3  # prior precision of a weight, over the mean square of its attribute
NAMES = tuple(ATTRIBUTES)
# attributes that can only speak for an answer, or against it, whatever a few cases say
FOR = {
    "first", "considered", "votes", "unknown_considered", "unknown_ahead", "unknown_ahead_share",
    "unexplained", "unexplained_share", "scatter", "unknown_failed", "nothing_considered",
}  # fmt: skip
AGAINST = {
    "behind", "behind_share", "not_fitted", "form_share", "large", "freedom", "failed", "misfit",
    "uneven", "nothing_gain", "nothing_apart",
}  # fmt: skip


def weights(questions: Sequence[Labelled]) -> dict[str, float]:
    """Return the most likely weights with a ridge, of the sign that each can have.

    Families count as they do in the benchmark.

    Questions whose right answers are not among the alternatives tell nothing of them.
    """
    use = [q for q in questions if q.right & {a.name for a in q.asked.alternatives}]
    tables = [np.array([[a.attributes.get(k, 0.0) for k in NAMES] for a in q.asked.alternatives])
              for q in use]  # fmt: skip
    right = [np.array([a.name in q.right for a in q.asked.alternatives]) for q in use]
    each = _shares(use)
    scale = np.sqrt(np.mean(np.concatenate(tables) ** 2, axis=0)) + 1e-12

    def loss(w: FloatArray) -> tuple[float, FloatArray]:
        value, slope = 0.5 * RIDGE * float(w @ w), RIDGE * w
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


def likelier_than_right(questions: Sequence[Labelled], answers: CalibratedAnswers) -> FloatArray:
    """Return the probability of all answers before the first right one; infinite: there is none."""
    found = [(q, likelier(answers.probabilities(q.asked))) for q in questions]
    return np.array([min(before.get(name, np.inf) for name in q.right) for q, before in found])


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


def calibrated(questions: Sequence[Labelled]) -> CalibratedAnswers:
    """Return weights from all questions, contents from worlds that weights were not fitted to."""
    none, foreign = dict.fromkeys(SAID, 1.0), np.zeros(len(questions))
    for world in {q.world for q in questions}:
        own = np.array([q.world == world for q in questions])
        others = [q for q in questions if q.world != world]
        foreign[own] = likelier_than_right(
            [q for q in questions if q.world == world], CalibratedAnswers(weights(others), none)
        )
    of, each = np.array([said(q.asked) for q in questions]), _shares(questions)
    contents = {
        what: max(content(foreign[of == what], each[of == what]), LEAST_CONTENT) for what in SAID
    }
    return CalibratedAnswers(weights(questions), contents)
