"""Fits the weights and thresholds of `model.discrepancy.answers.calibrated_answers`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from benchmarks.worlds.cases import SHARES
from benchmarks.worlds.right_answers import Labelled
from model.discrepancy.answers.calibrated_answers import KINDS, CalibratedAnswers, kind_of
from model.discrepancy.answers.choice_set import ATTRIBUTES
from model.measurements import FloatArray

COVERAGE = 0.95
ROUNDING = 1e-9
RIDGE = 1.0  # prior precision of a weight, over the mean square of its attribute
NAMES = tuple(ATTRIBUTES)


def weights(questions: Sequence[Labelled]) -> dict[str, float]:
    """Return the most likely weights with a ridge; families count as they do in the benchmark.

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

    found = minimize(loss, np.zeros(len(NAMES)), jac=True, method="L-BFGS-B")
    return dict(zip(NAMES, (found.x / scale).tolist(), strict=True))


def _shares(questions: Sequence[Labelled]) -> FloatArray:
    """Return how much each question counts, so that families count as in the benchmark; mean 1."""
    counts = Counter(q.family for q in questions)
    each = np.array([SHARES[q.family] / counts[q.family] for q in questions])
    return each / np.mean(each) if len(each) else each


def of_right(questions: Sequence[Labelled], answers: CalibratedAnswers) -> FloatArray:
    """Return the probability of the likeliest right answer of each question."""
    found = [(q, answers.probabilities(q.asked)) for q in questions]
    return np.array([max(p.get(name, 0.0) for name in q.right) for q, p in found])


def threshold(found: FloatArray, each: FloatArray, coverage: float = COVERAGE) -> float:
    """Return the largest value that a share `coverage` of further ones reaches at least.

    `each`: how much each value counts. Where all count alike it is the k-th smallest of n with
    k = floor((1 - coverage)(n + 1)); 0 where n is too small (Vovk, Gammerman and Shafer 2005; with
    weights Tibshirani et al. 2019, Adv. Neural Inf. Process. Syst. 32, the next one counting as
    much as any).
    """
    if not len(found):
        return 0.0
    order = np.argsort(found)
    below = np.cumsum(each[order])
    k = int(np.sum(below <= (1.0 - coverage) * (below[-1] + np.max(each)) * (1.0 + ROUNDING)))
    return float(found[order[k - 1]]) if k else 0.0


def calibrated(questions: Sequence[Labelled]) -> CalibratedAnswers:
    """Return weights from all questions, thresholds from worlds that weights were not fitted to."""
    none, foreign = dict.fromkeys(KINDS, 0.0), np.zeros(len(questions))
    for world in {q.world for q in questions}:
        own = np.array([q.world == world for q in questions])
        others = [q for q in questions if q.world != world]
        foreign[own] = of_right(
            [q for q in questions if q.world == world], CalibratedAnswers(weights(others), none)
        )
    kinds, each = np.array([kind_of(q.asked.considered) for q in questions]), _shares(questions)
    limits = {kind: threshold(foreign[kinds == kind], each[kinds == kind]) for kind in KINDS}
    return CalibratedAnswers(weights(questions), limits)
