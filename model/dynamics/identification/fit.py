"""`identify`: parameters of the moving sheet from recorded runs.

Gauss-Newton on the logarithms (Levenberg and Marquardt's damping where a step fails), with whitened
residuals of force, current and curves of all runs at once and weak priors.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from model.dynamics.beam import DynamicBeam
from model.dynamics.identification.noise import RecordingNoise, tempered
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.residuals import FINE, RunResiduals, coarser
from model.dynamics.identification.runs import RecordedRun
from model.dynamics.identification.uncertainty import DynamicParameter, judged
from model.dynamics.motion import Resolution
from model.measurements import FloatArray, ModelError

LONGEST = 1.0  # step of a logarithm
BEGIN = 1.0  # a beginning is near enough when a step is this short, in standard deviations
CONTRACTION = 0.1  # a step this much shorter than the last needs no new matrices
MOST_STEPS = 25
LEAST_GAIN = 0.01  # of the cost: with exact derivatives too little to go on for ...
NEAR = 0.1  # ... and as good as found when the step left is this short
MOST_DAMPING, ROUGH_DAMPING = 1e8, 10.0


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


@dataclass(frozen=True)
class _Point:
    """Where the search is."""

    theta: FloatArray
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
        coarse = coarser(resolution)
        self._rough = [RunResiduals(run.plan, noise, coarse) for run in runs]

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
        return _Point(theta, each, chi2, cost)

    def jacobians(
        self, at: _Point, *, symmetric: bool = False, exact: bool = False
    ) -> list[FloatArray]:
        """Return d prediction/d theta of each run, whitened; 0 where nothing was seen.

        Long steps are good enough, but where data say next to nothing: what is compared with the
        data is computed with short ones. exact: short steps and central differences.
        """
        out = []
        for of, run in zip(self.forward if exact else self._rough, self.runs, strict=True):
            J = of.sensitivity(self.parameters, at.theta, symmetric=symmetric or exact)
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


@dataclass(frozen=True)
class _Found:
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
    the parameters (0.1 of them where no step makes the fit better). resolution: None: FINE. near:
    `start` is near the answer; else the electrodes are found from the current alone, then all
    parameters from the begin of each run, then from everything. Raises ModelError.
    """
    parameters = LogParameters(start)
    problem, search = _found(
        parameters, runs, noise, resolution=resolution or FINE, tolerance=tolerance, near=near
    )
    at = search.at
    data = problem.information(at)
    found, covariance = judged(parameters, at.theta, data, max(1.0, at.chi2 / problem.count))
    return Identification(
        beam=parameters.beam(at.theta), parameters=found, covariance=covariance, chi2=at.chi2,
        count=problem.count, steps=search.steps, converged=search.converged,
    )  # fmt: skip


def best_sheet(
    start: DynamicBeam,
    runs: Sequence[RecordedRun],
    noise: RecordingNoise,
    *,
    resolution: Resolution | None = None,
    tolerance: float = 0.02,
    near: bool = False,
) -> DynamicBeam:
    """Return the sheet of `identify` alone: intervals cost as much as several steps of a search."""
    parameters = LogParameters(start)
    _, search = _found(
        parameters, runs, noise, resolution=resolution or FINE, tolerance=tolerance, near=near
    )
    return parameters.beam(search.at.theta)


def _found(
    parameters: LogParameters, runs: Sequence[RecordedRun], noise: RecordingNoise, *,
    resolution: Resolution, tolerance: float, near: bool,
) -> tuple[_Problem, _Found]:  # fmt: skip
    _refuse(runs)
    theta = parameters.theta
    for some, louder, by in () if near else _beginnings(runs, noise, resolution):
        theta = _search(_Problem(parameters, some, louder, by), theta, BEGIN).at.theta
    problem = _Problem(parameters, runs, noise, resolution)
    return problem, _search(problem, theta, tolerance)


@dataclass(frozen=True)
class _Stage:
    """A part of the data to begin with: until so long after the first edge, how much noisier."""

    until_s: float
    temper: float


STAGES = (_Stage(0.35, 30.0), _Stage(1.0, 10.0), _Stage(np.inf, 3.0))


def _beginnings(
    runs: Sequence[RecordedRun], noise: RecordingNoise, fine: Resolution
) -> Iterator[tuple[list[RecordedRun], RecordingNoise, Resolution]]:
    """Yield what leads near the answer for little time: each knows the last one's place.

    One swing first, so that no period is counted wrongly; noise taken for stronger than it is, so
    that the loss does not run away to explain a frequency that is still wrong.
    """
    currents = [run.current_alone() for run in runs if run.plan.current]
    if currents:
        yield currents, noise, fine
    coarse = coarser(fine)
    for stage in STAGES:
        some = [run.until(_first_edge_s(run) + stage.until_s) for run in runs]
        yield some, tempered(noise, stage.temper), coarse


def _first_edge_s(run: RecordedRun) -> float:
    """Return when the voltage first changes; a run may begin under one."""
    edges = run.plan.drive.time_s
    return float(edges[edges > 0.0][0]) if np.any(edges > 0.0) else 0.0


def _search(problem: _Problem, theta: FloatArray, tolerance: float) -> _Found:
    """Step until a step is short; a step shorter by far than the last needs no new matrices.

    Where derivatives with long steps lead nowhere, those with short ones are taken.
    """
    at = problem.point(theta)
    exact = False
    jacobians, fresh, damping, before = problem.jacobians(at), True, 0.0, 0.0
    steps, length = 0, np.inf
    while steps < MOST_STEPS:
        steps += 1
        hessian, gradient, length = problem.equations(at, jacobians)
        if not fresh and length > CONTRACTION * before:
            jacobians, fresh = problem.jacobians(at, exact=exact), True
            hessian, gradient, length = problem.equations(at, jacobians)
        most = MOST_DAMPING if exact else ROUGH_DAMPING
        cost = at.cost
        at, damping, moved = _step(problem, at, hessian, gradient, damping, most)
        gained = cost - at.cost
        if length < tolerance or (exact and fresh and gained < LEAST_GAIN):
            break
        exact = exact or (fresh and not moved)
        before, fresh = length if moved else 0.0, False
    return _Found(at, steps, length < max(tolerance, NEAR))


def _step(
    problem: _Problem, at: _Point, hessian: FloatArray, gradient: FloatArray, damping: float,
    most: float,
) -> tuple[_Point, float, bool]:  # fmt: skip
    """Return a better point, the damping that led there, and whether there was one."""
    while damping < most:
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
