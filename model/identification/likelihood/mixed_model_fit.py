"""Fits base parameters and active effects together, with the noise found on the way."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.identification.likelihood.form_error import Found, effect_columns, moved
from model.identification.likelihood.forward_model import AppliedEffect, ForwardModel
from model.identification.likelihood.linearisation import (
    Bases,
    Linearisation,
    linearise,
    with_columns,
)
from model.identification.likelihood.mixed_model import (
    Solution,
    deviance,
    estimate,
    inverse_symmetric,
    weigh,
)
from model.identification.likelihood.row_noise import RowNoise, guess_of
from model.measurements import FloatArray, ModelError

ROUNDS = 12
WORSE = 0.5  # of the deviance; less may be rounding
SHORTEST = 0.2  # share of a step; where not even that helps there is nowhere to go
LONGEST_STEP, LONGEST_LOG_B = 40.0, 0.2
ROUGH, FINE = 0.1, 1e-3  # of the deviance


@dataclass(frozen=True)
class FitProblem:
    """A data set with everything about it that does not change."""

    study: ForwardModel
    bases: Bases
    noise: RowNoise
    guess: FloatArray

    @staticmethod
    def of(study: ForwardModel, bases: Bases, noise: RowNoise) -> FitProblem:
        """With the assumed scatter."""
        return FitProblem(study, bases, noise, guess_of(noise))


@dataclass(frozen=True)
class MixedModelFit:
    """A model that has settled."""

    problem: FitProblem
    theta: FloatArray
    found: tuple[Found, ...]
    linear: Linearisation  # with the columns of the effects' parameters and of their form errors
    solution: Solution
    deviance: float
    spans: tuple[slice, ...]  # columns of each effect: its parameters first

    @property
    def active(self) -> tuple[AppliedEffect, ...]:
        """The effects as the states have them."""
        return tuple(f.active for f in self.found)


def fit_mixed_model(
    problem: FitProblem,
    theta: FloatArray,
    found: tuple[Found, ...] = (),
    log_sigma: FloatArray | None = None,
    form: float = 1.0,
) -> MixedModelFit:
    """Gauss-Newton with REML; a `ModelError` where it does not settle.

    `form` is how much of the tolerance of the effects' forms there is.
    """
    last: _Iteration | None = None
    for turn in range(ROUNDS):
        # the noise is estimated from the first: a model far off must not be taken at its word
        here = _Iteration.of(problem, theta, found, last.log_sigma if last else log_sigma, form)
        if last is not None and here.worse_than(last):
            # where the model bends much a whole step leads too far
            last = replace(last, share=0.5 * last.share if last.share > SHORTEST else 0.0)
            theta, found, _ = last.end()
            if last.share > 0.0:
                continue
            break
        last = here
        theta, found, quiet = here.end()
        if here.small and quiet and turn >= 2:
            break
    if last is None or not np.all(np.isfinite(theta)):
        raise ModelError("the fit did not settle: the data contradict the model too much")
    linear, spans = _linear(problem, theta, found, form)
    solution = estimate(linear.data, problem.guess, last.log_sigma, FINE)
    value = deviance(linear.data, solution.log_sigma, problem.guess)[0]
    value += prior_terms(linear, problem.bases.size)
    return MixedModelFit(problem, theta, found, linear, solution, value, tuple(spans))


@dataclass(frozen=True)
class _Iteration:
    """A model with the step that leads on from it."""

    problem: FitProblem
    theta: FloatArray
    found: tuple[Found, ...]
    linear: Linearisation
    spans: list[slice]
    solution: Solution
    share: float = 1.0  # of the step that is gone

    @staticmethod
    def of(
        problem: FitProblem, theta: FloatArray, found: tuple[Found, ...], start: FloatArray | None,
        form: float,
    ) -> _Iteration:  # fmt: skip
        """Linearised where it is, with the noise estimated from `start` on."""
        linear, spans = _linear(problem, theta, found, form)
        solution = estimate(linear.data, problem.guess, start, ROUGH)
        return _Iteration(problem, theta, found, linear, spans, solution)

    @property
    def log_sigma(self) -> FloatArray:
        """Of all scatter and noise."""
        return self.solution.log_sigma

    @property
    def sigma(self) -> FloatArray:
        """Of each parameter."""
        return np.sqrt(np.maximum(np.diag(self.solution.covariance), 1e-300))

    @property
    def small(self) -> bool:
        """Whether no base parameter has far to go."""
        size = self.problem.bases.size
        return bool(np.max(np.abs(self.solution.beta[:size]) / self.sigma[:size]) < 0.05)

    def worse_than(self, other: _Iteration) -> bool:
        """Whether it is further from the data, both before their steps, at the other's noise."""
        return self._distance(other.log_sigma) > other._distance(other.log_sigma) + WORSE

    def _distance(self, log_sigma: FloatArray) -> float:
        """Square of what is left, whitened, with no step but in the tolerance of the forms."""
        data = self.linear.data
        solution = weigh(data, log_sigma)
        error = data.y - data.X @ solution.beta
        We = (solution.weights @ error[:, :, None])[:, :, 0]
        promised = float(np.sum(error * We))
        promised += float(np.sum(data.precision * (solution.beta + data.away) ** 2))
        moving = np.arange(self.problem.bases.size).tolist()
        for one, span in zip(self.found, self.spans, strict=True):
            moving += range(span.start, span.start + len(one.parameters()))
        step, inner = solution.beta[moving], solution.covariance[np.ix_(moving, moving)]
        return promised + float(step @ inverse_symmetric(inner) @ step)

    def end(self) -> tuple[FloatArray, tuple[Found, ...], bool]:
        """Base parameters and effects after the step; whether the effects moved little."""
        beta = self.share * self.solution.beta
        found, quiet = moved(self.found, beta, self.sigma, self.spans)
        step = _bounded(self.problem, self.solution.beta[: self.problem.bases.size])
        return self.theta + self.share * step, found, quiet


def _bounded(problem: FitProblem, step: FloatArray) -> FloatArray:
    """No step leaps where the linearisation means nothing: neither of ln B nor of the others."""
    stiffness = [one.stiffness for one in problem.bases.parts]
    too_far = max(
        1.0,
        float(np.max(np.abs(step))) / LONGEST_STEP,
        float(np.max(np.abs(step[stiffness]))) / LONGEST_LOG_B,
    )
    return step / too_far


def prior_terms(linear: Linearisation, size: int) -> float:
    """-ln of the determinant of the effects' priors, which `deviance` leaves out."""
    return -float(np.sum(np.log(linear.data.precision[size:])))


def _linear(
    problem: FitProblem, theta: FloatArray, found: tuple[Found, ...], form: float
) -> tuple[Linearisation, list[slice]]:
    active = tuple(f.active for f in found)
    linear, spans = linearise(problem.study, problem.bases, problem.noise, theta, active), []
    for one in found:
        columns, precision, away = effect_columns(problem.study, linear, one, active)
        first = linear.columns.shape[1]
        precision[len(one.parameters()) :] /= form**2
        linear = with_columns(problem.study, linear, columns, precision, away)
        spans.append(slice(first, linear.columns.shape[1]))
    return linear, spans
