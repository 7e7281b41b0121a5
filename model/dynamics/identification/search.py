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
from model.dynamics.identification.thresholds import MOST_LEFT
from model.dynamics.motion import Resolution
from model.measurements import FloatArray, ModelError

LONGEST = 1.0  # step of a logarithm
CONTRACTION = 0.7  # a step this much shorter than the last needs no new derivatives
FROM_NEAR = 0.15  # standard deviations from where they were computed, that the end may be
MOST_STEPS = 25
LAST_STEPS = 0.5  # a step that is shorter, in standard deviations, is worth exact derivatives
LEAST_GAIN = 0.01  # of the cost: with exact derivatives too little to go on for ...
NEAR = 0.1  # ... and as good as found when the step left is this short
MOST_BACK = 4  # steps with the same derivatives after one that led too far
MOST_DAMPING, ROUGH_DAMPING = 1e8, 10.0


@dataclass(frozen=True)
class SearchPoint:
    """Where the search is."""

    theta: FloatArray
    residuals: list[FloatArray]  # whitened, of each run
    chi2: float  # of the data
    cost: float  # with the priors


@dataclass(frozen=True)
class Derivatives:
    """d prediction/d theta, whitened, of each run, at some logarithms."""

    theta: FloatArray
    each: list[FloatArray]  # (n, p)
    exact: bool  # with steps as short as those of the predictions
    computed: FloatArray  # the logarithms at which they were computed, not learnt

    @property
    def fresh(self) -> bool:
        """Return whether they are as computed."""
        return self.theta is self.computed


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

    def reached(self, at: SearchPoint, towards: FloatArray) -> SearchPoint | None:
        """Return where a step leads; None: to no sheet, or to one that leaves the rolls."""
        try:
            return self.point(at.theta + self.parameters.step(towards, LONGEST))
        except ModelError:
            return None

    def derivatives(self, theta: FloatArray, *, exact: bool = False) -> Derivatives:
        """Return d prediction/d theta.

        Long steps are good enough, but where data say next to nothing: what is compared with the
        data is computed with short ones. exact: short steps.
        """
        each = self._jacobians(self.forward if exact else self._rough, theta)
        return Derivatives(theta, each, exact, theta)

    def _jacobians(self, by: list[RunResiduals], theta: FloatArray) -> list[FloatArray]:
        """Return them of each run; 0 where nothing was seen."""
        out = []
        for of, run in zip(by, self.runs, strict=True):
            J = of.sensitivity(self.parameters, theta, symmetric=False)
            if run.x_m is not None and run.y_m is not None:
                J[len(J) - run.x_m.size :][~np.isfinite(run.x_m + run.y_m).ravel()] = 0.0
            out.append(J)
        return out

    def equations(
        self, at: SearchPoint, known: Derivatives
    ) -> tuple[FloatArray, FloatArray, float]:
        """Return half the cost's Hessian, minus half its gradient, and how long a step is.

        The length is in standard deviations of the parameters.
        """
        moved, precision = at.theta - self.parameters.theta, self.parameters.precision
        hessian, gradient = np.diag(precision), -precision * moved
        grown = self.parameters.grown(at.theta - known.theta)
        for near, r in zip(known.each, at.residuals, strict=True):
            J = near * grown
            hessian = hessian + J.T @ J
            gradient = gradient + J.T @ r
        length = np.sqrt(gradient @ np.linalg.solve(hessian, gradient) / len(gradient))
        return hessian, gradient, float(length)

    def learnt(self, known: Derivatives, at: SearchPoint, new: SearchPoint) -> Derivatives:
        """Return derivatives that say of a step what came of it (Broyden 1965).

        Of all that do they differ the least from those known, in standard deviations.
        """
        step, middle = new.theta - at.theta, 0.5 * (at.theta + new.theta)
        hessian = self.equations(at, known)[0]
        variance = np.diag(np.linalg.inv(hessian))
        if not step.any():
            return known
        along = step / variance / float(step @ (step / variance))
        halfway, grown = (self.parameters.grown(to - known.theta) for to in (middle, new.theta))
        each = [
            J * grown + np.outer(r - r_new - (J * halfway) @ step, along)
            for J, r, r_new in zip(known.each, at.residuals, new.residuals, strict=True)
        ]
        return Derivatives(new.theta, each, known.exact, known.computed)

    def away(self, at: SearchPoint, known: Derivatives) -> float:
        """Return how far it is from where derivatives were computed, in standard deviations."""
        far = at.theta - known.computed
        return float(np.sqrt(far @ self.equations(at, known)[0] @ far / len(far)))

    def rough_information(self, theta: FloatArray) -> FloatArray:
        """Return J'J (p, p) of all runs with steps of a millisecond, to compare places."""
        return squares(self._jacobians(self._between, theta))

    @property
    def count(self) -> int:
        """Return the number of values that are compared."""
        return sum(of.count(run) for of, run in zip(self.forward, self.runs, strict=True))


@dataclass(frozen=True, kw_only=True)
class SearchEnd:
    """Where a search ended."""

    at: SearchPoint
    steps: int
    converged: bool
    left: float  # of the cost, that the next step may gain
    exact: Derivatives | None = None  # with short steps, if any were taken

    @property
    def least_cost(self) -> float:
        """Return the cost that a search from here on might come to."""
        return self.at.cost - min(self.left, MOST_LEFT)

    def information(self, problem: SearchProblem) -> FloatArray:
        """Return J'J (p, p) with short steps: long ones misjudge what is faster than they are."""
        known = self.exact or problem.derivatives(self.at.theta, exact=True)
        grown = problem.parameters.grown(self.at.theta - known.theta)
        return squares([near * grown for near in known.each])


def squares(jacobians: list[FloatArray]) -> FloatArray:
    """Return J'J (p, p) of all runs, what the data say of the parameters."""
    return np.asarray(sum(J.T @ J for J in jacobians))


def search(
    problem: SearchProblem, theta: FloatArray, tolerance: float, *, finish: bool = False
) -> SearchEnd:
    """Step until a step is short; derivatives are computed anew where steps do not grow shorter.

    Where derivatives with long steps lead nowhere, those with short ones are taken; with `finish`
    also for the last steps.
    """
    at, known, exact = problem.point(theta), problem.derivatives(theta), False
    steps, length, before, damping = 0, np.inf, 0.0, 0.0
    clean = None  # the last exact derivatives as they were computed
    while steps < MOST_STEPS:
        steps += 1
        length = problem.equations(at, known)[2]
        again = not known.fresh and length > CONTRACTION * before
        again |= exact and not known.exact  # long steps led nowhere
        if finish and length < max(tolerance, LAST_STEPS):
            again |= not known.exact
            again |= length < tolerance and problem.away(at, known) > FROM_NEAR
            exact |= again
        if again:
            known, damping = problem.derivatives(at.theta, exact=exact), 0.0
            length = problem.equations(at, known)[2]
        fresh = known.fresh
        clean = known if fresh and known.exact else clean
        new, damping, moved = _step(
            problem, at, known, damping, MOST_DAMPING if exact else ROUGH_DAMPING
        )
        known = problem.learnt(known, at, new) if moved else known
        gained, at = at.cost - new.cost, new
        if length < tolerance or (exact and fresh and gained < LEAST_GAIN):
            break
        exact = exact or (fresh and not moved)
        before = length if moved else 0.0
    converged, left = length < max(tolerance, NEAR), length**2 * len(at.theta)
    return SearchEnd(at=at, steps=steps, converged=converged, left=left, exact=clean)


def _step(
    problem: SearchProblem, at: SearchPoint, known: Derivatives, damping: float, most: float
) -> tuple[SearchPoint, float, bool]:  # fmt: skip
    """Return a better point, the damping that led there, and whether there was one.

    Where several parameters make up for one another along a curve a straight step leaves it: more
    of them with the same derivatives lead back.
    """
    hessian, gradient, _ = problem.equations(at, known)
    while damping < most:
        damped = hessian + damping * np.diag(np.diag(hessian))
        new = problem.reached(at, np.asarray(np.linalg.solve(damped, gradient)))
        for _ in range(MOST_BACK):
            if new is None or new.cost <= at.cost:
                break
            back = problem.equations(new, known)[1]
            nearer = problem.reached(new, np.asarray(np.linalg.solve(damped, back)))
            if nearer is None or nearer.cost > new.cost:
                break
            new = nearer
        if new is not None and new.cost <= at.cost:
            return new, damping * 0.1 if damping > 1e-5 else 0.0, True
        damping = max(1e-4, 10.0 * damping)
    return at, 0.0, False
