"""Find single conditions that are outliers: mistakes of handling, not missing effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.discrepancy.search.evidence import Candidate
from model.identification.data.data_vector import Index
from model.identification.likelihood.mixed_model_fit import FitProblem, MixedModelFit
from model.identification.likelihood.random_effects import ASSUMED
from model.measurements import FloatArray

SIZES = (0.3, 1.0, 3.0, 10.0)
FORCE_N, MODE_M = 1e-4, 2e-5
SET_UP = ("stiffness", "eibm", "position", "clamp_tilt", "registration", "force_zero")
SET_UP_SIZES = (4.0, 8.0, 16.0)
OUT = 1e6  # how much noisier a condition left out is taken to be


def outlier_candidates(fitted: MixedModelFit) -> list[Candidate]:
    """One for each condition, whose force and curve may be anything, and one for each set-up."""
    forward, result, number = fitted.problem.forward, _setups(fitted), 0
    for c, part in enumerate(forward.layout.parts):
        scene, state = forward.scenes[c], fitted.linear.states[c]
        for k in range(scene.K):
            columns = []
            own = part.trend_rows[(part.trend_of == k) & part.is_mean]
            if len(own):
                columns.append(_at(forward.layout.size, own, FORCE_N))
            if scene.has_curve[k]:
                rows = part.mode_rows[k]
                columns += [
                    _at(forward.layout.size, rows[m : m + 1], MODE_M / (1 + m))
                    for m in range(min(4, scene.modes))
                ]
                if scene.voltage_V[k] != 0.0:  # its EIBM was another one
                    both = np.zeros(forward.layout.size)
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
    layout, result = fitted.problem.forward.layout, []
    sigma = np.exp(fitted.solution.log_sigma)
    numbers = condition_runs(fitted.problem)
    for r in range(len(layout.runs)):
        columns = []
        for value, name, Z in zip(sigma, ASSUMED, fitted.linear.data.groups, strict=False):
            if name in SET_UP:
                for q in range(Z.shape[2]):
                    column = np.zeros(layout.size)
                    own = layout.run_of == r
                    column[own] = value * Z[r, layout.row_of[own], q]
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
    layout = problem.forward.layout
    return [layout.runs.index(one.run) for look in problem.forward.looks for one in look.seen]


def _at(size: int, rows: Index, value: float) -> FloatArray:
    column = np.zeros(size)
    column[rows] = value
    return column


def numbers_of(name: str) -> list[int]:
    """Return the conditions of an outlier candidate."""
    return [int(n) for n in name.removeprefix("outlier:").split(",")]


def condition_name(problem: FitProblem, number: int) -> str:
    """As people call it."""
    names = [one.name for look in problem.forward.looks for one in look.seen]
    return names[number]


def without(problem: FitProblem, numbers: list[int]) -> FitProblem:
    """Return the same data with some conditions so noisy that they do not count."""
    fixed, forward = problem.noise.fixed.copy(), problem.forward
    first = 0
    for part, scene in zip(forward.layout.parts, forward.scenes, strict=True):
        for k in (n - first for n in numbers):
            if 0 <= k < scene.K:
                fixed[part.trend_rows[part.trend_of == k]] += OUT * 1e-8
                rows = part.mode_rows[k]
                fixed[rows[rows >= 0]] += OUT * 1e-8
        first += scene.K
    return replace(problem, noise=replace(problem.noise, fixed=fixed))
