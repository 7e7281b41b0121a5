"""Set-ups that differ by more than set-ups do: something unknown changes with each of them.

The scatter of stiffness, EIBM, place on the arc and zero of the load cell is estimated from the
data, and so is that of the EIBM from one condition of a set-up to the next. So what is another one
in each of them, without an order that a nonparametric term describes, is taken up by it. Where it
is many times as large as usual, a term in which each has an amount of its own competes at the usual
scatter; so does a force that wanders slowly in each run. How well camera and sheet come back to
their places is a matter of the rig: of these nothing is usual.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from model.discrepancy.search.evidence import Candidate, Projected, scored
from model.discrepancy.search.ranking import RankedCandidate, best_of_each
from model.discrepancy.thresholds import EXCESSIVE_SCATTER_RATIO
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray

PART = "each set-up"
# where each acts, and its unit as it is reported, with the factor from that of the scatter
LOCATIONS = {
    "stiffness": ("compliance", "relative", -1.0), "eibm": ("eibm", "relative", 1.0),
    "position": ("position", "mm", 1e3), "force_zero": ("load_cell", "mN", 1e3),
    "eibm_condition": ("eibm", "relative", 1.0), "sway_slow": ("time", "mN", 1e3),
}  # fmt: skip
SIZES = (1.0, 3.0, 10.0, 30.0, 100.0)  # of the usual scatter


def unusual_set_ups(fitted: MixedModelFit) -> list[RankedCandidate]:
    """Return terms of what differs by too much, the best first; empty: nothing does."""
    unusual = {name: one for name, one in _times(fitted).items() if one > EXCESSIVE_SCATTER_RATIO}
    if not unusual:
        return []
    forward, names = fitted.problem.forward, list(fitted.problem.noise.random_effects)
    usual = fitted.solution.log_sigma.copy()
    for name in unusual:
        usual[names.index(name)] = fitted.problem.guess[names.index(name)]
    solution = weigh(fitted.linear.data, usual)
    pool = [_candidate(fitted, name) for name in unusual]
    scores = scored(forward, Projected.of(forward, fitted.linear, solution), pool)
    return best_of_each(scores, solution)


def of_set_ups(candidate: RankedCandidate) -> str:
    """Return which scatter a term of each set-up is; empty: it is another term."""
    part = candidate.score.candidate.part
    return part.removeprefix(f"{PART}, ") if part.startswith(f"{PART}, ") else ""


@dataclass(frozen=True, kw_only=True)
class SetUpOffsets:
    """How far the set-ups of a configuration are off, in the unit that is reported; (n,)."""

    configuration: str
    position_mm: FloatArray
    off: FloatArray
    sigma: FloatArray
    unit: str
    times: float  # of the usual standard deviation


def largest_offsets(
    fitted: MixedModelFit, name: str, beta: FloatArray, C: FloatArray
) -> SetUpOffsets:
    """Return the configuration whose set-ups a term's sizes move most; C: covariance.

    Where a set-up has several of them, those of the voltage at which they are largest.
    """
    forward = fitted.problem.forward
    unit_size = _usual(fitted, name) * LOCATIONS[name][2]
    places = [_positions(fitted, c) for c in range(len(forward.names))]
    by_run = (len(forward.row_index.runs), -1)
    size, variance = beta.reshape(by_run), np.maximum(np.diag(C), 0.0).reshape(by_run)
    sums = np.array([np.sum(size[list(own)] ** 2, axis=0) for own in places])
    c, which = (int(k) for k in np.unravel_index(np.argmax(sums), sums.shape))
    runs = sorted(places[c], key=lambda run: places[c][run])
    return SetUpOffsets(
        configuration=forward.names[c],
        position_mm=1e3 * np.array([places[c][run] for run in runs]),
        off=unit_size * size[runs, which], sigma=abs(unit_size) * np.sqrt(variance[runs, which]),
        unit=LOCATIONS[name][1], times=_times(fitted)[name],
    )  # fmt: skip


def _positions(fitted: MixedModelFit, c: int) -> Mapping[int, float]:
    """Return the position of each run of a configuration, m; without free shapes."""
    runs = fitted.problem.forward.row_index.runs
    seen = fitted.problem.forward.data_vectors[c].seen
    return {runs.index(one.run): one.position_m for one in seen if np.isfinite(one.position_m)}


def _times(fitted: MixedModelFit) -> dict[str, float]:
    """Return each scatter over its usual size."""
    above = np.exp(fitted.solution.log_sigma - fitted.problem.guess)
    names = fitted.problem.noise.random_effects
    return {name: float(above[k]) for k, name in enumerate(names) if name in LOCATIONS}


def _usual(fitted: MixedModelFit, name: str) -> float:
    names = list(fitted.problem.noise.random_effects)
    return float(np.exp(fitted.problem.guess[names.index(name)]))


def _candidate(fitted: MixedModelFit, name: str) -> Candidate:
    """Return the term in which each run has amounts of its own: columns (N, runs times amounts)."""
    row_index, names = fitted.problem.forward.row_index, list(fitted.problem.noise.random_effects)
    group = fitted.linear.data.groups[names.index(name)]
    columns = np.zeros((row_index.size, len(row_index.runs), group.shape[2]))
    columns[np.arange(row_index.size), row_index.run_of] = (
        _usual(fitted, name) * group[row_index.run_of, row_index.row_of]
    )
    location = LOCATIONS[name][0]
    return Candidate(
        name=f"unknown:{location}", values={}, columns=columns.reshape(row_index.size, -1),
        sizes=SIZES, location=location,
        part=f"{PART}, {name}",
    )  # fmt: skip
