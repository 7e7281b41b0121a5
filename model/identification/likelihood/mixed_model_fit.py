"""Fit of base parameters and active effects together with the noise."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from model.identification.likelihood.effort import Effort
from model.identification.likelihood.form_error import effect_columns
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import (
    Bases,
    Linearisation,
    linearise,
    with_columns,
)
from model.identification.likelihood.mixed_model import (
    Solution,
    effects,
    estimate,
    inverse_symmetric,
    unsettled,
    weigh,
)
from model.identification.likelihood.model_state import AppliedEffect, FitPlace, Found, moved
from model.identification.likelihood.noise.row_noise import RowNoise, guess_of
from model.identification.likelihood.noise.scatter_uncertainty import Spread, freedom, spread
from model.identification.likelihood.one_sense import within_range
from model.identification.likelihood.random_effects import Added
from model.identification.priors.shared_widths import estimated_widths
from model.measurements import FloatArray, ModelError
from model.parameter import Parameter

ROUNDS = 12
# rounds after which a fit ends that gains no more than so much of the deviance, and moves less
# than so many standard uncertainties
MANY, LITTLE, NEARLY = 4, 1.0, 1.0
WORSE = 0.5  # of the deviance; less may be rounding
SHORTEST = 0.2  # share of a step; where not even that helps there is nowhere to go
# of a standard uncertainty: moves of base parameters, of effects, at which a fit has settled; the
# third one where each set-up is
SMALL, SMALL_OF_EFFECT, QUIET = 0.05, 0.1, 0.01
LONGEST_STEP, LONGEST_LOG_B = 40.0, 0.2
ROUGH, FAIR, FINE = 0.5, 0.1, 1e-3  # of the deviance


@dataclass(frozen=True, kw_only=True)
class FitProblem:
    """A data set with everything about it that does not change."""

    forward: ForwardModel
    bases: Bases
    noise: RowNoise
    guess: FloatArray
    # columns (N, q) of something that no effect is, as a straight line, and the precision of each
    free: tuple[FloatArray, float] | None = field(default=None, compare=False, repr=False)
    effort: Effort = field(default_factory=Effort, compare=False, repr=False)

    @staticmethod
    def of(forward: ForwardModel, bases: Bases, noise: RowNoise) -> FitProblem:
        """With the assumed scatter."""
        return FitProblem(forward=forward, bases=bases, noise=noise, guess=guess_of(noise))

    def noise_names(self) -> list[str]:
        """Return the names of all standard deviations: scatters, then noises."""
        return [*self.noise.random_effects, *self.noise.names]

    def noise_from(self, known: Mapping[str, float]) -> FloatArray:
        """Return ln of all standard deviations: those known by name, else as assumed."""
        pairs = zip(self.noise_names(), self.guess.tolist(), strict=True)
        return np.array([known.get(name, guess) for name, guess in pairs])


@dataclass(frozen=True, kw_only=True)
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

    def noise_found(self) -> dict[str, float]:
        """Return ln of all standard deviations by name: scatters, then noises."""
        values = self.solution.log_sigma.tolist()
        return dict(zip(self.problem.noise_names(), values, strict=True))

    def added(self) -> Added:
        """Return the most likely values (R, q) of every random effect."""
        return _added(self.problem, self.linear, self.solution)

    @cached_property
    def spread(self) -> Spread:
        """How sure the estimated scatter itself is."""
        return spread(self.linear.data, self.solution)

    @cached_property
    def covariance(self) -> FloatArray:
        """Of all parameters, with what the estimated scatter adds: (p, p)."""
        return self.solution.covariance + self.spread.kackar_harville()

    def parameter(
        self, value: float, direction: FloatArray, unit: str, more: float = 0.0
    ) -> Parameter:
        """Return a quantity as a parameter; `direction` holds its derivatives by all parameters.

        `more` is an additional systematic standard uncertainty.
        """
        sigma = float(np.sqrt(direction @ self.covariance @ direction + more**2))
        return Parameter(value=value, sigma=sigma, unit=unit, freedom=self.freedom(direction))

    def freedom(self, direction: FloatArray) -> float:
        """Return the degrees of freedom of a quantity of these derivatives."""
        return freedom(self.solution, self.spread, direction)


def fit_mixed_model(
    problem: FitProblem,
    theta: FloatArray,
    found: tuple[Found, ...] = (),
    log_sigma: FloatArray | None = None,
    form: float = 1.0,
    worthless: float = np.inf,
) -> MixedModelFit:
    """Gauss-Newton with REML; a `ModelError` where it does not settle.

    `form` is how much of the tolerance of the effects' forms there is. A fit whose deviance is
    still above `worthless` when it should be near its end is given up there.
    """
    *_, there = approach(problem, theta, found, log_sigma, form, worthless)
    return _finished(
        _LinearisationPoint(
            problem=problem, theta=there.theta, found=there.found, added=None, form=form
        ),
        there.log_sigma,
    )


def approach(
    problem: FitProblem,
    theta: FloatArray,
    found: tuple[Found, ...] = (),
    log_sigma: FloatArray | None = None,
    form: float = 1.0,
    worthless: float = np.inf,
) -> Iterator[FitPlace]:
    """Yield the places after the steps of a fit, one at least, until it has settled.

    Where it has not after all rounds, as with a form that has kinks, the last one is the best.
    """
    last: _Iteration | None = None
    best: _Iteration | None = None
    share = 1.0  # of the last one's step that is gone
    for turn in range(ROUNDS):
        # the noise is estimated from the first: a model far off must not be taken at its word
        noise = last.log_sigma if last else log_sigma
        here = _tried(
            last,
            _LinearisationPoint(problem=problem, theta=theta, found=found, added=None, form=form),
            noise,
        )
        if here is None or (last is not None and here.worse_than(last)):
            assert last is not None  # noqa: S101 - see `_tried`
            # where the model bends much a whole step leads too far
            share = 0.5 * share if share > SHORTEST else 0.0
            theta, found, _ = last.end(share)
            if share > 0.0:
                continue
            yield FitPlace(theta=theta, found=found, log_sigma=last.log_sigma)
            return
        gained = np.inf if last is None else last.value - here.value
        last, share = here, 1.0
        best = here if best is None or here.so_far < best.so_far else best
        theta, found, effects_move = here.end()
        yield FitPlace(theta=theta, found=found, log_sigma=here.log_sigma)
        if here.moves < SMALL and effects_move < SMALL_OF_EFFECT:
            return
        # a form with kinks, as of friction, may go to and fro
        if turn >= MANY and (here.value > worthless or (gained < LITTLE and here.moves < NEARLY)):
            return
    if last is None or best is None:
        raise unsettled()
    at = _LinearisationPoint(problem=problem, theta=theta, found=found, added=None, form=form)
    here = _tried(last, at, last.log_sigma)
    if here is not None and here.so_far < best.so_far:
        best = here
    yield FitPlace(theta=best.at.theta, found=best.at.found, log_sigma=best.log_sigma)


def fit_at_set_ups(
    problem: FitProblem, theta: FloatArray, log_sigma: FloatArray | None = None
) -> MixedModelFit:
    """Fit the base model, solved for each set-up at its most likely random effects.

    `log_sigma`: standard deviations to begin with; None: those that are assumed.

    Random effects large enough to bend the model would otherwise get a wrong weight. Where this
    does not converge, the model is fitted to nominal set-ups.
    """
    at = _LinearisationPoint(problem=problem, theta=theta, found=(), added=None)
    noise = log_sigma
    with suppress(ModelError):
        for _ in range(ROUNDS):
            here = _Iteration.of(at, noise, FAIR)
            noise = here.log_sigma
            at = _LinearisationPoint(
                problem=_with_widths_told(here), theta=here.end()[0], found=(),
                added=_added(problem, here.linear, here.solution),
            )  # fmt: skip
            if here.moves < QUIET:
                return _finished(at, noise)
    return fit_mixed_model(problem, theta)


@dataclass(frozen=True, kw_only=True)
class _LinearisationPoint:
    """Where the model is linearised."""

    problem: FitProblem
    theta: FloatArray
    found: tuple[Found, ...]
    added: Added | None  # by each set-up; None: all are nominal
    form: float = 1.0

    def linearised(self) -> tuple[Linearisation, list[slice]]:
        """Return the data linearised about this point, and the columns of each effect."""
        problem, spans = self.problem, list[slice]()
        problem.effort.solutions += 1
        active = tuple(f.active for f in self.found)
        linear = linearise(
            problem.forward, problem.bases, problem.noise, self.theta, active, self.added
        )
        for one in self.found:
            columns, precision, away = effect_columns(problem.forward, linear, one, active)
            first = linear.columns.shape[1]
            precision[len(one.parameters()) :] /= (self.form * one.form) ** 2
            linear = with_columns(problem.forward, linear, columns, precision, away)
            spans.append(slice(first, linear.columns.shape[1]))
        if problem.free is not None:  # behind the effects: a fit does not move by them
            linear = with_columns(problem.forward, linear, *problem.free)
        return linear, spans


def _finished(at: _LinearisationPoint, log_sigma: FloatArray) -> MixedModelFit:
    """Return the fit at a linearisation point, with its noise."""
    if not np.all(np.isfinite(at.theta)):
        raise unsettled()
    linear, spans = at.linearised()
    if at.found:
        linear = within_range(linear, at.found, spans, weigh(linear.data, log_sigma), share=0.0)
    problem = at.problem
    solution = estimate(linear.data, problem.guess, log_sigma, FINE)
    value = solution.deviance + prior_terms(linear, problem.bases.size)
    return MixedModelFit(
        problem=problem,
        theta=at.theta,
        found=at.found,
        linear=linear,
        solution=solution,
        deviance=value,
        spans=tuple(spans),
    )


def weighed_at(
    problem: FitProblem, theta: FloatArray, found: tuple[Found, ...], log_sigma: FloatArray
) -> MixedModelFit:
    """Return the model where it is, at given noise: nothing is fitted, so it has no deviance."""
    at = _LinearisationPoint(problem=problem, theta=theta, found=found, added=None)
    linear, spans = at.linearised()
    return MixedModelFit(
        problem=problem, theta=theta, found=found, linear=linear,
        solution=weigh(linear.data, log_sigma), deviance=np.nan, spans=tuple(spans),
    )  # fmt: skip


def without_free(fitted: MixedModelFit) -> MixedModelFit:
    """Return a fit beside free columns at the same place without them."""
    problem = replace(fitted.problem, free=None)
    at = _LinearisationPoint(problem=problem, theta=fitted.theta, found=fitted.found, added=None)
    return _finished(at, fitted.solution.log_sigma)


@dataclass(frozen=True, kw_only=True)
class _Iteration:
    """A model with the step that leads on from it."""

    at: _LinearisationPoint
    linear: Linearisation
    spans: list[slice]
    start: FloatArray  # ln sigma from which on the noise is estimated
    accuracy: float

    @staticmethod
    def of(
        at: _LinearisationPoint, start: FloatArray | None, accuracy: float = ROUGH
    ) -> _Iteration:
        """Linearised where it is, with the noise to be estimated from `start` on."""
        linear, spans = at.linearised()
        start = at.problem.guess if start is None else start
        return _Iteration(at=at, linear=linear, spans=spans, start=start, accuracy=accuracy)

    @cached_property
    def _at_start(self) -> Solution:
        """The solution at the noise it begins with."""
        return weigh(self.linear.data, self.start)

    @cached_property
    def _in_range(self) -> Linearisation:
        return within_range(self.linear, self.at.found, self.spans, self._at_start)

    @cached_property
    def solution(self) -> Solution:
        """The solution with the noise estimated; a step that is taken back needs none."""
        data, guess = self._in_range.data, self.at.problem.guess
        return estimate(data, guess, self.start, self.accuracy, there=self._at_start)

    @property
    def value(self) -> float:
        """The deviance at the end of its step, as far as a straight line goes."""
        return self.solution.deviance + prior_terms(self._in_range, self.at.problem.bases.size)

    @cached_property
    def so_far(self) -> float:
        """The deviance before its step, with no more than the tolerance of the forms."""
        return self.value + self._from_data - self._promised(self.solution)

    @property
    def log_sigma(self) -> FloatArray:
        """Of all scatter and noise."""
        return self.solution.log_sigma

    @property
    def sigma(self) -> FloatArray:
        """Of each parameter."""
        return np.sqrt(np.maximum(np.diag(self.solution.covariance), 1e-300))

    @property
    def moves(self) -> float:
        """How far the base parameters have to go, at most, in standard uncertainties."""
        size = self.at.problem.bases.size
        return float(np.max(np.abs(self.solution.beta[:size]) / self.sigma[:size]))

    def worse_than(self, other: _Iteration) -> bool:
        """Whether it is further from the data, both before their steps, at the other's noise.

        That is the noise this one begins with.
        """
        return self._distance(self._at_start) > other._from_data + WORSE

    @cached_property
    def _from_data(self) -> float:
        free = self._in_range is self.linear
        return self._distance(self.solution if free else weigh(self.linear.data, self.log_sigma))

    def _distance(self, solution: Solution) -> float:
        """Square of what is left, whitened, with no step but in the tolerance of the forms.

        The solution is that of steps without bounds.
        """
        moving = self._moving()
        step, inner = solution.beta[moving], solution.covariance[np.ix_(moving, moving)]
        return self._promised(solution) + float(step @ inverse_symmetric(inner) @ step)

    def _promised(self, solution: Solution) -> float:
        """Square of what is left after its step, as far as a straight line goes."""
        data = self.linear.data
        error = data.y - data.X @ solution.beta
        We = (solution.weights @ error[:, :, None])[:, :, 0]
        promised = float(np.sum(error * We))
        return promised + float(np.sum(data.precision * (solution.beta + data.away) ** 2))

    def _moving(self) -> list[int]:
        """Return the places of everything that a step changes."""
        moving = list(range(self.at.problem.bases.size))
        for one, span in zip(self.at.found, self.spans, strict=True):
            moving += range(span.start, span.start + len(one.parameters()) + len(one.ways))
        return moving

    def end(self, share: float = 1.0) -> tuple[FloatArray, tuple[Found, ...], float]:
        """Return base parameters and effects after the step, and how far effects move at most.

        That is in standard uncertainties. `share` of the step is gone.
        """
        beta = share * self.solution.beta
        found, largest = moved(self.at.found, beta, self.sigma, self.spans)
        step = _bounded(self.at.problem, self.solution.beta[: self.at.problem.bases.size])
        return self.at.theta + share * step, found, largest


def _with_widths_told(here: _Iteration) -> FitProblem:
    """Return the problem with the shared widths of priors that the data ask for there."""
    problem = here.at.problem
    shared = estimated_widths(problem.bases.shared, here.linear.data, here.solution)
    return replace(problem, bases=replace(problem.bases, shared=shared))


def _added(problem: FitProblem, linear: Linearisation, solution: Solution) -> Added:
    """Return the most likely values (R, q) of every random effect."""
    return dict(zip(problem.noise.random_effects, effects(linear.data, solution), strict=True))


def _tried(
    last: _Iteration | None, at: _LinearisationPoint, start: FloatArray | None
) -> _Iteration | None:
    """Return the model there; None where a step from `last` led to where it has no answer."""
    try:
        return _Iteration.of(at, start)
    except ModelError:
        if last is None:
            raise
        return None


def _bounded(problem: FitProblem, step: FloatArray) -> FloatArray:
    """No step leaps where the linearisation means nothing: neither of ln B nor of the others."""
    stiffness = [one.stiffness for one in problem.bases.parts]
    longest = LONGEST_STEP * max(1.0, problem.forward.scale.per_length)
    too_far = max(
        1.0,
        float(np.max(np.abs(step))) / longest,
        float(np.max(np.abs(step[stiffness]))) / LONGEST_LOG_B,
    )
    return step / too_far


def prior_terms(linear: Linearisation, size: int) -> float:
    """-ln of the determinant of the effects' priors, which `deviance` leaves out."""
    return -float(np.sum(np.log(linear.data.precision[size:])))
