"""Compute the evidence threshold from simulated sessions without any effect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model.discrepancy.search.evidence import Candidate, Projected, averaged, score
from model.discrepancy.thresholds import FALSE_NAME_RATE
from model.identification.likelihood.mixed_model import estimate
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray, Progress, silent


def null_gains(
    fitted: MixedModelFit,
    pool: Sequence[Candidate],
    count: int,
    seed: int,
    progress: Progress = silent,
) -> FloatArray:
    """Return the largest evidence of any candidate in `count` sessions drawn from the fitted model.

    Noise and scatter are drawn with their fitted sizes and uncertainties, and are estimated again
    in each session.
    """
    random = np.random.default_rng(seed)
    forward, linear, problem = fitted.problem.forward, fitted.linear, fitted.problem
    factor = np.linalg.cholesky(np.linalg.inv(fitted.solution.weights))
    empty = np.all(linear.data.X == 0.0, axis=2) & (linear.data.fixed == 1.0)
    result = np.zeros(count)
    for i in range(count):
        y = (factor @ random.standard_normal((*linear.data.y.shape, 1)))[:, :, 0]
        y[empty] = 0.0
        data = replace(linear.data, y=y, away=np.zeros_like(linear.data.away))
        flat = y[forward.row_index.run_of, forward.row_index.row_of]
        solution = estimate(data, problem.guess, fitted.solution.log_sigma, 0.05)
        drawn = replace(linear, residual=flat, data=data)
        weighed = Projected.of(forward, drawn, solution)
        gains: dict[str, list[float]] = {}
        for c in pool:
            gains.setdefault(c.name, []).append(score(forward, weighed, c).log_bayes)
        result[i] = max(averaged(shapes) for shapes in gains.values())
        progress((i + 1) / count, "simulating sessions of the base model")
    return result


def threshold(gains: FloatArray) -> float:
    """Return the gain that 1 in 100 such sessions exceeds, from the tail's exponential decay."""
    ordered = np.sort(gains)
    start = float(np.quantile(ordered, 0.8))
    excess = ordered[ordered > start] - start
    mean = float(np.mean(excess)) if len(excess) else 1.0
    return max(start + mean * float(np.log(0.2 / FALSE_NAME_RATE)), 2.0)
