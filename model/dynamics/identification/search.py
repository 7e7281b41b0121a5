"""The search for the sheet: Gauss-Newton on the logarithms, damped where a step fails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.dynamics.identification.noise import RecordingNoise
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.predicted_run import coarser, in_milliseconds
from model.dynamics.identification.residuals import RunResiduals
from model.dynamics.identification.runs import RecordedRun
from model.dynamics.motion import Resolution
from model.measurements import FloatArray, ModelError

LONGEST = 1.0  # step of a logarithm
CONTRACTION = 0.1  # a step this much shorter than the last needs no new matrices
MOST_STEPS = 25
LAST_STEPS = 1.0  # a step that is shorter, in standard deviations, is worth exact derivatives
LEAST_GAIN = 0.01  # of the cost: with exact derivatives too little to go on for ...
NEAR = 0.1  # ... and as good as found when the step left is this short
MOST_DAMPING, ROUGH_DAMPING = 1e8, 10.0


@dataclass(frozen=True)
class SearchPoint:
    """Where the search is."""

    theta: FloatArray
    residuals: list[FloatArray]  # whitened, of each run
    chi2: float  # of the data
    cost: float  # with the priors


class SearchProblem:
    """Runs with their data."""

    def __init__(
        self, parameters: LogParameters, runs: Sequence[RecordedRun], noise: RecordingNoise,
        resolution: Resolution,
    ) -> None:  # fmt: skip
        self.parameters, self.runs = parameters, runs
        self.forward = [RunResiduals(run.plan, noise, resolution) for run in runs]
        self._rough, self._between = (
            [of.with_resolution(by) for of in self.forward]
            for by in (coarser(resolution), in_milliseconds(resolution))
        )

    def point(self, theta: FloatArray) -> SearchPoint:
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
        return SearchPoint(theta, each, chi2, cost)

    def reached(self, theta: FloatArray) -> SearchPoint | None:
        """Return the same; None: there is no such sheet, or it leaves the rolls."""
        try:
            return self.point(theta)
        except ModelError:
            return None

    def jacobians(self, theta: FloatArray, *, exact: bool = False) -> list[FloatArray]:
        """Return d prediction/d theta of each run, whitened; 0 where nothing was seen.

        Long steps are good enough, but where data say next to nothing: what is compared with the
        data is computed with short ones. exact: short steps.
        """
        return self._jacobians(self.forward if exact else self._rough, theta)

    def _jacobians(self, by: list[RunResiduals], theta: FloatArray) -> list[FloatArray]:
        out = []
        for of, run in zip(by, self.runs, strict=True):
            J = of.sensitivity(self.parameters, theta, symmetric=False)
            if run.x_m is not None and run.y_m is not None:
                J[len(J) - run.x_m.size :][~np.isfinite(run.x_m + run.y_m).ravel()] = 0.0
            out.append(J)
        return out

    def equations(
        self, at: SearchPoint, jacobians: list[FloatArray]
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

    def rough_information(self, theta: FloatArray) -> FloatArray:
        """Return J'J (p, p) of all runs with steps of a millisecond, to compare places."""
        return squares(self._jacobians(self._between, theta))

    @property
    def count(self) -> int:
        """Return the number of values that are compared."""
        return sum(of.count(run) for of, run in zip(self.forward, self.runs, strict=True))


@dataclass(frozen=True)
class SearchEnd:
    """Where a search ended."""

    at: SearchPoint
    steps: int
    converged: bool
    exact: list[FloatArray] | None = None  # derivatives with short steps, if any were taken

    def information(self, problem: SearchProblem) -> FloatArray:
        """Return J'J (p, p) with short steps: long ones misjudge what is faster than they are."""
        return squares(self.exact or problem.jacobians(self.at.theta, exact=True))


def squares(jacobians: list[FloatArray]) -> FloatArray:
    """Return J'J (p, p) of all runs, what the data say of the parameters."""
    return np.asarray(sum(J.T @ J for J in jacobians))


def search(
    problem: SearchProblem, theta: FloatArray, tolerance: float, *, finish: bool = False
) -> SearchEnd:
    """Step until a step is short; a step shorter by far than the last needs no new matrices.

    Where derivatives with long steps lead nowhere, those with short ones are taken; with `finish`
    also for the last steps.
    """
    at = problem.point(theta)
    exact = precise = False  # are short steps asked for, are the matrices those of short steps
    jacobians, fresh, damping, before = problem.jacobians(at.theta), True, 0.0, 0.0
    steps, length = 0, np.inf
    while steps < MOST_STEPS:
        steps += 1
        hessian, gradient, length = problem.equations(at, jacobians)
        found = precise and length < tolerance
        if not fresh and not found and length > CONTRACTION * before:
            jacobians, fresh, precise = problem.jacobians(at.theta, exact=exact), True, exact
            hessian, gradient, length = problem.equations(at, jacobians)
        if finish and not precise and length < max(tolerance, LAST_STEPS):
            exact = precise = fresh = True
            damping = 0.0  # it was for long steps
            jacobians = problem.jacobians(at.theta, exact=True)
            hessian, gradient, length = problem.equations(at, jacobians)
        most = MOST_DAMPING if exact else ROUGH_DAMPING
        cost = at.cost
        at, damping, moved = _step(problem, at, jacobians, damping, most)
        gained = cost - at.cost
        if length < tolerance or (exact and fresh and gained < LEAST_GAIN):
            break
        exact = exact or (fresh and not moved)
        before, fresh = length if moved else 0.0, False
    return SearchEnd(at, steps, length < max(tolerance, NEAR), jacobians if precise else None)


def _step(
    problem: SearchProblem, at: SearchPoint, jacobians: list[FloatArray], damping: float,
    most: float,
) -> tuple[SearchPoint, float, bool]:  # fmt: skip
    """Return a better point, the damping that led there, and whether there was one.

    Where several parameters make up for one another along a curve a straight step leaves it: a
    second one with the same derivatives leads back.
    """
    hessian, gradient, _ = problem.equations(at, jacobians)
    while damping < most:
        damped = hessian + damping * np.diag(np.diag(hessian))
        for again in (False, True):
            begun, towards = at, gradient
            if again:
                begun, towards = new, problem.equations(new, jacobians)[1]
            step = problem.parameters.step(np.linalg.solve(damped, towards), LONGEST)
            new = problem.reached(begun.theta + step)
            if new is None:
                break
            if new.cost <= at.cost:
                return new, damping * 0.1 if damping > 1e-5 else 0.0, True
        damping = max(1e-4, 10.0 * damping)
    return at, 0.0, False
