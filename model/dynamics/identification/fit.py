"""`identify`: parameters of the moving sheet from recorded runs.

Gauss-Newton on the logarithms (Levenberg and Marquardt's damping where a step fails), with whitened
residuals of force, current and curves of all runs at once and weak priors.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from model.dynamics.beam import DynamicBeam
from model.dynamics.identification.noise import RecordingNoise
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.residuals import PredictedRun, RunResiduals
from model.dynamics.identification.runs import RecordedRun
from model.dynamics.identification.uncertainty import DynamicParameter, judged
from model.dynamics.motion import Resolution
from model.measurements import FloatArray, ModelError

LONGEST = 1.0  # step of a logarithm
BEGIN = 1.0  # a beginning is near enough when a step is this short, in standard deviations
CONTRACTION = 0.1  # a step this much shorter than the last needs no new matrices
BEGIN_S = 1.2  # of each run are enough to begin with: the phase of a ring-down is not yet lost
MOST_STEPS = 40
MOST_DAMPING = 1e8


@dataclass(frozen=True, kw_only=True)
class Identification:
    """What was found."""

    beam: DynamicBeam
    parameters: tuple[DynamicParameter, ...]
    covariance: FloatArray  # (p, p) of the logarithms
    chi2: float  # of the whitened residuals
    count: int  # of the values they stand for
    steps: int
    converged: bool

    def __getitem__(self, name: str) -> DynamicParameter:
        """Return a parameter by name."""
        return next(p for p in self.parameters if p.name == name)

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Return the names of the parameters that these data do not determine."""
        return tuple(p.name for p in self.parameters if not p.determined)


class _Point(NamedTuple):
    """Where the search is."""

    theta: FloatArray
    predictions: list[PredictedRun]
    residuals: list[FloatArray]  # whitened, of each run
    chi2: float  # of the data
    cost: float  # with the priors


class _Problem:
    """Runs with their data."""

    def __init__(
        self, parameters: LogParameters, runs: Sequence[RecordedRun], noise: RecordingNoise,
        resolution: Resolution,
    ) -> None:  # fmt: skip
        self.parameters, self.runs = parameters, runs
        self.forward = [RunResiduals(run.plan, noise, resolution) for run in runs]

    def point(self, theta: FloatArray) -> _Point:
        """Evaluate the model. Raises ModelError."""
        beam = self.parameters.beam(theta)
        said = [of.predict(beam) for of in self.forward]
        each = [
            of.whitened([(at, run)])[:, 0]
            for of, at, run in zip(self.forward, said, self.runs, strict=True)
        ]
        chi2 = float(sum(r @ r for r in each))
        moved = theta - self.parameters.theta
        cost = chi2 + float(moved @ (self.parameters.precision * moved))
        return _Point(theta, said, each, chi2, cost)

    def jacobians(self, at: _Point, symmetric: bool = False) -> list[FloatArray]:
        """Return d prediction/d theta of each run, whitened; 0 where nothing was seen."""
        out = []
        for of, said, run in zip(self.forward, at.predictions, self.runs, strict=True):
            find = of.symmetric_sensitivity if symmetric else of.sensitivity
            J = find(self.parameters, at.theta, said)
            if run.x_m is not None and run.y_m is not None:
                J[len(J) - run.x_m.size :][~np.isfinite(run.x_m + run.y_m).ravel()] = 0.0
            out.append(J)
        return out

    def equations(
        self, at: _Point, jacobians: list[FloatArray]
    ) -> tuple[FloatArray, FloatArray, float]:
        """Return half the cost's Hessian, minus half its gradient, and how long a step is.

        The length is in standard deviations of the parameters.
        """
        moved, precision = at.theta - self.parameters.theta, self.parameters.precision
        hessian, gradient = np.diag(precision), -precision * moved
        for J, r in zip(jacobians, at.residuals, strict=True):
            hessian = hessian + J.T @ J
            gradient = gradient + J.T @ r
        length = np.sqrt(gradient @ np.linalg.solve(hessian, gradient) / len(gradient))
        return hessian, gradient, float(length)

    def information(self, at: _Point) -> FloatArray:
        """Return J'J (p, p) of all runs, what the data say of the parameters."""
        matrices = self.jacobians(at, symmetric=True)
        return np.asarray(sum(J.T @ J for J in matrices))

    @property
    def count(self) -> int:
        """Return the number of values that are compared."""
        return sum(of.count(run) for of, run in zip(self.forward, self.runs, strict=True))


class _Found(NamedTuple):
    """Where a search ended."""

    at: _Point
    steps: int
    converged: bool


def identify(
    start: DynamicBeam,
    runs: Sequence[RecordedRun],
    noise: RecordingNoise,
    *,
    resolution: Resolution | None = None,
    tolerance: float = 0.02,
    near: bool = False,
) -> Identification:
    """Return the sheet that explains the runs.

    start: what is known (lengths, fluid, initial curvature, source), starting values and centres of
    the priors for what is not. tolerance: the last step is this short, in standard deviations of
    the parameters. near: `start` is near the answer; else the electrodes are found from the current
    alone, then all parameters from the first 1.2 s of each run, then from everything. Raises
    ModelError.
    """
    _refuse(runs)
    parameters, fine = LogParameters(start), resolution or Resolution()
    theta = parameters.theta
    for some, by in () if near else _beginnings(runs, fine):
        theta = _search(_Problem(parameters, some, noise, by), theta, BEGIN).at.theta
    problem = _Problem(parameters, runs, noise, fine)
    at, steps, converged = _search(problem, theta, tolerance)
    data = problem.information(at)
    found, covariance = judged(parameters, at.theta, data, max(1.0, at.chi2 / problem.count))
    return Identification(
        beam=parameters.beam(at.theta), parameters=found, covariance=covariance, chi2=at.chi2,
        count=problem.count, steps=steps, converged=converged,
    )  # fmt: skip


def _beginnings(
    runs: Sequence[RecordedRun], fine: Resolution
) -> Iterator[tuple[list[RecordedRun], Resolution]]:
    """Yield what leads near the answer for little time."""
    currents = [run.current_alone() for run in runs if run.plan.current]
    if currents:
        yield currents, fine
    yield [run.until(BEGIN_S) for run in runs], fine


def _search(problem: _Problem, theta: FloatArray, tolerance: float) -> _Found:
    """Step until a step is short; a step shorter by far than the last needs no new matrices."""
    at = problem.point(theta)
    jacobians, fresh, damping, before = problem.jacobians(at), True, 0.0, 0.0
    steps, length, ended = 0, np.inf, False
    while not ended and steps < MOST_STEPS:
        steps += 1
        hessian, gradient, length = problem.equations(at, jacobians)
        if not fresh and length > CONTRACTION * before:
            jacobians, fresh = problem.jacobians(at), True
            hessian, gradient, length = problem.equations(at, jacobians)
        at, damping, moved = _step(problem, at, hessian, gradient, damping)
        ended = length < tolerance or (fresh and not moved)
        before, fresh = length if moved else 0.0, False
    return _Found(at, steps, length < tolerance)


def _step(
    problem: _Problem, at: _Point, hessian: FloatArray, gradient: FloatArray, damping: float
) -> tuple[_Point, float, bool]:
    """Return a better point, the damping that led there, and whether there was one."""
    while damping < MOST_DAMPING:
        damped = hessian + damping * np.diag(np.diag(hessian))
        step = np.linalg.solve(damped, gradient)
        step *= min(1.0, LONGEST / float(np.max(np.abs(step), initial=LONGEST)))
        try:
            new = problem.point(at.theta + step)
        except ModelError:  # no sheet, or one that leaves the rolls
            new = None
        if new is not None and new.cost <= at.cost:
            return new, damping * 0.1 if damping > 1e-5 else 0.0, True
        damping = max(1e-4, 10.0 * damping)
    return at, 0.0, False


def _refuse(runs: Sequence[RecordedRun]) -> None:
    if not runs:
        raise ModelError("there is no recorded run to identify the sheet from")
    names = sorted({run.plan.configuration for run in runs})
    if len(names) > 1:
        raise ModelError(
            "a sheet is identified from runs of one configuration, not of " + " and ".join(names)
        )
