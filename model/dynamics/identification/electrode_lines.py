"""Electrodes that explain the current: of a search from several beginnings, all places it ends at.

A line with r, c and g so many times larger and rho as much smaller looks to the current like the
same line so many times longer: only what comes back from its end tells them apart. There are
minima about every factor of two. The current alone takes milliseconds: the sheet need not move.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil

import numpy as np

from model.dynamics.identification.noise import RecordingNoise
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.runs import RecordedRun
from model.dynamics.identification.search import SearchEnd, SearchProblem, search
from model.dynamics.identification.thresholds import RIVAL
from model.dynamics.motion import Resolution
from model.measurements import FloatArray

NEAR_ENOUGH = 1.0  # the last step of a search for a beginning, in standard deviations
LONGER = (0.0, -0.7, 0.7, -1.5, 1.5)  # logarithms, where a search begins
NEXT_LONGER, MOST_LONGER = (-0.7, 0.7), 4  # from the best, and how often it is gone on from
OTHER_LINES = (-2.1, -1.4, -0.7, 0.7, 1.4, 2.1, 2.8)  # where a search for others begins
# Polynomials. Too few for a line on which a voltage does not get far make currents of no line at
# all: with 12 one sixteen times longer explained a recording as well as the true one.
LINE_TERMS = 48
APART = 3.0  # standard deviations: ends farther from each other are different ones
MOST_SAMPLES = 500  # of a run, to begin with
MOTION_SAYS = 10.0  # chi2 by which force and frames may speak for what the current speaks against


def best_electrodes(
    parameters: LogParameters, runs: Sequence[RecordedRun], noise: RecordingNoise, by: Resolution
) -> FloatArray:
    """Return logarithms with the electrodes that explain the current best."""
    problem = _of_current(parameters, [_thinned(run) for run in runs], noise, by)
    if problem is None:
        return parameters.theta

    def best(begun: FloatArray, lengths: Sequence[float]) -> SearchEnd:
        ways = (begun + by * parameters.length_of_line for by in lengths)
        return min((search(problem, way, NEAR_ENOUGH) for way in ways), key=lambda e: e.at.cost)

    found = best(parameters.theta, LONGER)
    for _ in range(MOST_LONGER):
        other = best(found.at.theta, NEXT_LONGER)
        if other.at.cost > found.at.cost - 1.0:
            break
        found = other
    return found.at.theta


def other_electrodes(
    parameters: LogParameters, runs: Sequence[RecordedRun], noise: RecordingNoise, by: Resolution,
    theta: FloatArray,
) -> Iterator[FloatArray]:  # fmt: skip
    """Yield logarithms with other electrodes than those of `theta`, if the current allows them."""
    some = _of_current(parameters, [_thinned(run) for run in runs], noise, by)
    every = _of_current(parameters, runs, noise, by)
    if some is None or every is None:
        return
    few, here = (search(problem, theta, NEAR_ENOUGH) for problem in (some, every))
    H = every.equations(here.at, every.derivatives(here.at.theta))[0]
    sigma = np.sqrt(np.diag(np.linalg.inv(H)))
    known, told = [theta], parameters.length_of_line != 0.0

    def is_new(end: SearchEnd, best: SearchEnd) -> bool:
        away = min(float(np.max(np.abs(end.at.theta - one)[told] / sigma[told])) for one in known)
        return away > APART and end.least_cost < best.at.cost + RIVAL + MOTION_SAYS

    if is_new(here, here):
        known.append(here.at.theta)
        yield here.at.theta
    for length in OTHER_LINES:
        end = search(some, here.at.theta + length * parameters.length_of_line, NEAR_ENOUGH)
        if not is_new(end, few):
            continue
        end = search(every, end.at.theta, NEAR_ENOUGH)
        if is_new(end, here):
            known.append(end.at.theta)
            yield end.at.theta


def _thinned(run: RecordedRun) -> RecordedRun:
    """Return the current of some of the samples."""
    every = ceil(len(run.plan.time_s) / MOST_SAMPLES)
    if every < 2 or run.current_A is None:
        return run
    plan = replace(run.plan, time_s=run.plan.time_s[::every])
    thin = run.current_A[::every]
    force = None if run.force_N is None else run.force_N[::every]
    return replace(run, plan=plan, current_A=thin, force_N=force)


def _of_current(
    parameters: LogParameters, runs: Sequence[RecordedRun], noise: RecordingNoise, by: Resolution
) -> SearchProblem | None:
    currents = [run.current_alone() for run in runs if run.plan.current]
    if not currents:
        return None
    finely = replace(by, line_terms=max(by.line_terms, LINE_TERMS))
    return SearchProblem(parameters, currents, noise, finely)
