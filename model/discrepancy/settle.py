"""Fits base parameters and active effects together, with the noise found on the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.discrepancy.linear import Bases, Linear, linearise, with_columns
from model.discrepancy.point import Active, Study
from model.discrepancy.row_noise import Noise, guess_of
from model.discrepancy.tolerance import Found, effect_columns, moved
from model.measurements import FloatArray, ModelError
from model.noise import Solution, deviance, estimate

ROUNDS = 12
LONGEST_STEP, LONGEST_LOG_B = 40.0, 0.2
ROUGH, FINE = 0.1, 1e-3  # of the deviance


@dataclass(frozen=True)
class Problem:
    """A data set with everything about it that does not change."""

    study: Study
    bases: Bases
    noise: Noise
    guess: FloatArray

    @staticmethod
    def of(study: Study, bases: Bases, noise: Noise) -> Problem:
        """With the assumed scatter."""
        return Problem(study, bases, noise, guess_of(noise))


@dataclass(frozen=True)
class Fitted:
    """A model that has settled."""

    problem: Problem
    theta: FloatArray
    found: tuple[Found, ...]
    linear: Linear  # with the columns of the effects' knobs and of the tolerance of their form
    solution: Solution
    deviance: float
    spans: tuple[slice, ...]  # columns of each effect: its knobs first

    @property
    def active(self) -> tuple[Active, ...]:
        """The effects as the states have them."""
        return tuple(f.active for f in self.found)


def settle(
    problem: Problem,
    theta: FloatArray,
    found: tuple[Found, ...] = (),
    log_sigma: FloatArray | None = None,
) -> Fitted:
    """Gauss-Newton with REML; a `ModelError` where it does not settle."""
    solution: Solution | None = None
    for turn in range(ROUNDS):
        linear, spans = _linear(problem, theta, found)
        # the noise is estimated from the first: a model far off must not be taken at its word
        start = log_sigma if solution is None else solution.log_sigma
        solution = estimate(linear.data, problem.guess, start, ROUGH)
        sigma = np.sqrt(np.maximum(np.diag(solution.covariance), 1e-300))
        size = problem.bases.size
        small = np.max(np.abs(solution.beta[:size]) / sigma[:size]) < 0.05
        step = _bounded(problem, solution.beta[:size])
        found, quiet = moved(found, solution.beta, sigma, spans)
        theta = theta + step
        if small and quiet and turn >= 2:
            break
    if not np.all(np.isfinite(theta)):
        raise ModelError("the fit did not settle: the data contradict the model too much")
    linear, spans = _linear(problem, theta, found)
    solution = estimate(linear.data, problem.guess, solution.log_sigma, FINE)  # type: ignore[union-attr]
    value = deviance(linear.data, solution.log_sigma, problem.guess)[0]
    value += prior_terms(linear, size)
    return Fitted(problem, theta, found, linear, solution, value, tuple(spans))


def _bounded(problem: Problem, step: FloatArray) -> FloatArray:
    """No step leaps where the linearisation means nothing: neither of ln B nor of the others."""
    stiffness = [one.stiffness for one in problem.bases.parts]
    too_far = max(
        1.0,
        float(np.max(np.abs(step))) / LONGEST_STEP,
        float(np.max(np.abs(step[stiffness]))) / LONGEST_LOG_B,
    )
    return step / too_far


def prior_terms(linear: Linear, size: int) -> float:
    """-ln of the determinant of the effects' priors, which `deviance` leaves out."""
    return -float(np.sum(np.log(linear.data.precision[size:])))


def _linear(
    problem: Problem, theta: FloatArray, found: tuple[Found, ...]
) -> tuple[Linear, list[slice]]:
    active = tuple(f.active for f in found)
    linear, spans = linearise(problem.study, problem.bases, problem.noise, theta, active), []
    for one in found:
        columns, precision, away = effect_columns(problem.study, linear, one, active)
        first = linear.columns.shape[1]
        linear = with_columns(problem.study, linear, columns, precision, away)
        spans.append(slice(first, linear.columns.shape[1]))
    return linear, spans
