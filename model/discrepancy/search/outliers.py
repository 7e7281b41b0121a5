"""Find single conditions that are outliers: mistakes of handling, not missing effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.discrepancy.search.evidence import Candidate
from model.discrepancy.verdict.prediction_error import variance
from model.identification.data.data_vector import Index
from model.identification.likelihood.mixed_model_fit import FitProblem, MixedModelFit
from model.identification.likelihood.random_effects import ASSUMED
from model.measurements import FloatArray

SIZES = (0.3, 1.0, 3.0, 10.0)
FORCE_N, MODE_M = 1e-4, 2e-5
SET_UP = ("stiffness", "eibm", "position", "clamp_tilt", "registration", "force_zero")
SET_UP_SIZES = (4.0, 8.0, 16.0)
OUT = 1e6  # times the variance of a condition that is left out


def outlier_candidates(fitted: MixedModelFit) -> list[Candidate]:
    """One for each condition, whose force and curve may be anything, and one for each set-up."""
    forward, result, number = fitted.problem.forward, _setups(fitted), 0
    for c, block in enumerate(forward.row_index.blocks):
        configuration_model, state = forward.configuration_models[c], fitted.linear.states[c]
        for k in range(configuration_model.K):
            columns = []
            own = block.trend_rows[(block.trend_of == k) & block.is_mean]
            if len(own):
                columns.append(_at(forward.row_index.size, own, FORCE_N * forward.scale.force))
            if configuration_model.has_curve[k]:
                rows = block.mode_rows[k]
                columns += [
                    _at(
                        forward.row_index.size,
                        rows[m : m + 1],
                        MODE_M * forward.scale.length / (1 + m),
                    )
                    for m in range(min(4, configuration_model.modes))
                ]
                if configuration_model.voltage_V[k] != 0.0:  # its EIBM was another one
                    both = np.zeros(forward.row_index.size)
                    both[rows] = 0.05 * state.modes_by_eibm[k]
                    both[own] = 0.05 * state.by_eibm[k]
                    columns.append(both)
            name = f"outlier:{number}"
            result.append(
                Candidate(
                    name=name,
                    values={},
                    columns=np.stack(columns, axis=1),
                    sizes=SIZES,
                    effect=None,
                    location="outlier",
                )
            )
            number += 1
    return result


def _setups(fitted: MixedModelFit) -> list[Candidate]:
    """Set-ups with another B, EIBM, position, tilt, registration and zero than all others."""
    row_index, result = fitted.problem.forward.row_index, []
    sigma = np.exp(fitted.solution.log_sigma)
    numbers = condition_runs(fitted.problem)
    for r in range(len(row_index.runs)):
        columns = []
        for value, name, Z in zip(sigma, ASSUMED, fitted.linear.data.groups, strict=False):
            if name in SET_UP:
                for q in range(Z.shape[2]):
                    column = np.zeros(row_index.size)
                    own = row_index.run_of == r
                    column[own] = value * Z[r, row_index.row_of[own], q]
                    columns.append(column)
        own_numbers = [str(n) for n, run in enumerate(numbers) if run == r]
        if len(own_numbers) > 1:
            name = "outlier:" + ",".join(own_numbers)
            result.append(
                Candidate(
                    name=name,
                    values={},
                    columns=np.stack(columns, axis=1),
                    sizes=SET_UP_SIZES,
                    effect=None,
                    location="outlier",
                )
            )
    return result


def condition_runs(problem: FitProblem) -> list[int]:
    """Return the run of each condition, by its number over all configurations."""
    row_index = problem.forward.row_index
    return [
        row_index.runs.index(one.run)
        for data_vector in problem.forward.data_vectors
        for one in data_vector.seen
    ]


def _at(size: int, rows: Index, value: float) -> FloatArray:
    column = np.zeros(size)
    column[rows] = value
    return column


def numbers_of(name: str) -> list[int]:
    """Return the conditions of an outlier candidate."""
    return [int(n) for n in name.removeprefix("outlier:").split(",")]


def condition_name(problem: FitProblem, number: int) -> str:
    """As people call it."""
    names = [one.name for data_vector in problem.forward.data_vectors for one in data_vector.seen]
    return names[number]


def without(fitted: MixedModelFit, numbers: list[int]) -> FitProblem:
    """Return the data of a fit with some conditions so noisy that they do not count."""
    problem, first = fitted.problem, 0
    out = np.zeros(problem.forward.row_index.size, dtype=bool)
    for block in problem.forward.row_index.blocks:
        count = len(block.mode_rows)
        for k in (n - first for n in numbers):
            if 0 <= k < count:
                out |= block.of_condition(k, len(out))
        first += count
    fixed = np.where(out, OUT * variance(fitted), problem.noise.fixed)
    return replace(problem, noise=replace(problem.noise, fixed=fixed))
