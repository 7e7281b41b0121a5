"""`identify`: parameters of the moving sheet from recorded runs.

Gauss-Newton on the logarithms (Levenberg and Marquardt's damping where a step fails), with whitened
residuals of force, current and curves of all runs at once and weak priors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from model.dynamics.beam import DynamicBeam
from model.dynamics.identification.electrode_lines import best_electrodes, other_electrodes
from model.dynamics.identification.noise import RecordingNoise, tempered
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.predicted_run import FINE, coarser
from model.dynamics.identification.rivals import best_and_rivals, covering_both
from model.dynamics.identification.runs import RecordedRun
from model.dynamics.identification.search import SearchProblem, search
from model.dynamics.identification.thresholds import GUARD, LEAST_MISFIT, SURE_MISFIT
from model.dynamics.identification.uncertainty import DynamicParameter, judged, surely
from model.dynamics.motion import Resolution
from model.measurements import FloatArray, ModelError

BEGIN = 1.0  # a beginning is near enough when a step is this short, in standard deviations


class NotConvergedError(ModelError):
    """A search that must converge did not."""


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
    def misses_data(self) -> bool:
        """Return whether more is left than the noise explains: a wrong place or a wrong model."""
        return _misses(self.chi2, self.count)

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Return the names of the parameters that these data do not determine."""
        return tuple(p.name for p in self.parameters if not p.determined)


def identify(
    start: DynamicBeam,
    runs: Sequence[RecordedRun],
    noise: RecordingNoise,
    *,
    resolution: Resolution | None = None,
    tolerance: float = 0.02,
    near: bool = False,
    must_converge: bool = False,
) -> Identification:
    """Return the sheet that explains the runs.

    start: what is known (lengths, fluid, initial curvature, source), starting values and centres of
    the priors for what is not. tolerance: the last step is this short, in standard deviations of
    the parameters (0.1 of them where no step makes the fit better). resolution: None: FINE. near:
    `start` is near the answer; else the electrodes are found from the current alone, then all
    parameters from the begin of each run, then from everything. Where other electrodes explain the
    data as well, an interval covers both, or the parameter is not determined. must_converge: raise
    NotConvergedError where the search does not converge, in place of minutes of searches for other
    electrodes. Raises ModelError.
    """
    parameters = LogParameters(start)
    _refuse(runs)
    by = resolution or FINE
    begun = parameters.theta if near else _beginning(parameters, runs, noise, by)
    problem = SearchProblem(parameters, runs, noise, by)
    first = search(problem, begun, tolerance, finish=True)
    if must_converge and not first.converged:
        raise NotConvergedError("the search for the moving sheet did not converge")
    others = other_electrodes(parameters, runs, noise, by, first.at.theta)
    ended, rivals = best_and_rivals(problem, first, others, tolerance)
    at = ended.at
    scale = max(1.0, at.chi2 / problem.count)
    found, covariance = judged(parameters, at.theta, ended.information(problem), scale, GUARD)

    def there(theta: FloatArray) -> tuple[DynamicParameter, ...]:
        return judged(parameters, theta, problem.rough_information(theta), scale)[0]

    found = surely(found, covariance, at.theta, parameters.theta, there)
    for rival in rivals:
        found = covering_both(found, there(rival.at.theta))
    if not ended.converged and _misses(at.chi2, problem.count):  # it is not known where it is
        found = tuple(replace(one, determined=False) for one in found)
    return Identification(
        beam=parameters.beam(at.theta), parameters=found, covariance=covariance, chi2=at.chi2,
        count=problem.count, steps=ended.steps, converged=ended.converged,
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
    _refuse(runs)
    parameters, by = LogParameters(start), resolution or FINE
    begun = parameters.theta if near else _beginning(parameters, runs, noise, by)
    problem = SearchProblem(parameters, runs, noise, by)
    return parameters.beam(search(problem, begun, tolerance).at.theta)


@dataclass(frozen=True)
class _Stage:
    """A part of the data to begin with: until so long after the first edge, how much noisier."""

    until_s: float
    temper: float


STAGES = (_Stage(0.35, 30.0), _Stage(1.0, 10.0), _Stage(np.inf, 3.0))


def _beginning(
    parameters: LogParameters, runs: Sequence[RecordedRun], noise: RecordingNoise, fine: Resolution
) -> FloatArray:
    """Return logarithms near the answer for little time: each stage knows the last one's place.

    One swing first, so that no period is counted wrongly; noise taken for stronger than it is, so
    that the loss does not run away to explain a frequency that is still wrong.
    """
    theta = best_electrodes(parameters, runs, noise, fine)
    coarse = coarser(fine)
    for stage in STAGES:
        some = [run.until(_first_edge_s(run) + stage.until_s) for run in runs]
        problem = SearchProblem(parameters, some, tempered(noise, stage.temper), coarse)
        theta = search(problem, theta, BEGIN).at.theta
    return theta


def _first_edge_s(run: RecordedRun) -> float:
    """Return when the voltage first changes; a run may begin under one."""
    edges = run.plan.drive.time_s
    return float(edges[edges > 0.0][0]) if np.any(edges > 0.0) else 0.0


def _misses(chi2: float, count: int) -> bool:
    usual = max(LEAST_MISFIT, SURE_MISFIT * sqrt(2.0 / count))
    return chi2 > count * (1.0 + usual)


def _refuse(runs: Sequence[RecordedRun]) -> None:
    if not runs:
        raise ModelError("there is no recorded run to identify the sheet from")
    names = sorted({run.plan.configuration for run in runs})
    if len(names) > 1:
        raise ModelError(
            "a sheet is identified from runs of one configuration, not of " + " and ".join(names)
        )
