"""A Gaussian process for what the base model leaves: it closes a gap and names nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from model.discrepancy.verdict import prediction_error as gaps
from model.discrepancy.verdict.result import BeforeAfter
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray

LENGTHS_M = (2.5e-3, 5e-3, 10e-3, 20e-3, 40e-3)
NOISES = (0.01, 0.03, 0.1, 0.3, 0.9)  # share of the residual's variance
Index = npt.NDArray[np.int64]
Runs = npt.NDArray[np.bool_]  # (R,) some of all runs


def gaussian_process(base: MixedModelFit, noise: FloatArray) -> float | None:
    """Share of the gap on left-out positions that it closes.

    One process along the arc for each force and each mode of the curves, at each voltage of each
    configuration; length and noise by maximum likelihood, the same for all voltages.
    """
    where = gaps.cells(base)
    series = along_arc(base)
    before, after = gaps.refitted(base), gaps.refitted(base)
    shape = likeliest(base)
    row_index = base.problem.forward.row_index
    positions = np.array([run[1] for run in row_index.runs])
    for at in np.unique(positions[np.isfinite(positions)]):
        runs = positions == at
        left, out = _without(base, runs), runs[row_index.run_of]
        before[out] = after[out] = left[out]
        for kind, own in series.items():
            for rows, at_m in own:
                mine = out[rows]
                if mine.any() and not mine.all():
                    known_y = left[rows[~mine]]
                    foretold = guess(at_m[~mine], known_y, at_m[mine], *shape[kind])
                    after[rows[mine]] = left[rows[mine]] - foretold
    both = BeforeAfter(gaps.gap(before, noise, where), gaps.gap(after, noise, where))
    closed = gaps.closed_share(both, gaps.floor(noise, where))
    return closed if np.isfinite(closed) else None


def along_arc(base: MixedModelFit) -> dict[str, list[tuple[Index, FloatArray]]]:
    """Rows along the arc, with their positions; those of all voltages have one smoothness."""
    found: dict[tuple[str, int, float, int], list[tuple[int, float]]] = {}
    forward = base.problem.forward
    for c, (block, configuration_model) in enumerate(
        zip(forward.row_index.blocks, forward.configuration_models, strict=True)
    ):
        for row, k in zip(
            block.trend_rows[block.is_mean], block.trend_of[block.is_mean], strict=True
        ):
            key = ("force", c, float(configuration_model.voltage_V[k]), 0)
            found.setdefault(key, []).append((int(row), float(configuration_model.stated_m[k])))
        for k in np.flatnonzero(
            configuration_model.has_curve & np.isfinite(configuration_model.stated_m)
        ):
            for m, row in enumerate(block.mode_rows[k]):
                key = ("curve", c, float(configuration_model.voltage_V[k]), m)
                found.setdefault(key, []).append((int(row), float(configuration_model.stated_m[k])))
    result: dict[str, list[tuple[Index, FloatArray]]] = {}
    for (kind, c, _, m), cells in found.items():
        rows, at_m = zip(*cells, strict=True)
        result.setdefault(f"{kind} {c} {m}", []).append((np.array(rows), np.array(at_m)))
    return result


def kernel(a_m: FloatArray, b_m: FloatArray, length_m: float) -> FloatArray:
    result: FloatArray = np.exp(-0.5 * ((a_m[:, None] - b_m) / length_m) ** 2)
    return result


def likeliest(base: MixedModelFit) -> dict[str, tuple[float, float]]:
    """Return length (m) and share of noise of each kind of row along the arc."""
    return {k: _likeliest(gaps.refitted(base), own) for k, own in along_arc(base).items()}


def _likeliest(y: FloatArray, series: Sequence[tuple[Index, FloatArray]]) -> tuple[float, float]:
    """Length and share of noise; each series has its own size."""

    def misfit(length_m: float, noise: float) -> float:
        total = 0.0
        for rows, at_m in series:
            n = len(rows)
            V = (1.0 - noise) * kernel(at_m, at_m, length_m) + noise * np.eye(n)
            square = float(y[rows] @ np.linalg.solve(V, y[rows]))
            total += n * np.log(max(square, 1e-300)) + float(np.linalg.slogdet(V)[1])
        return total

    return min(((a, b) for a in LENGTHS_M for b in NOISES), key=lambda p: misfit(*p))


def guess(
    at_m: FloatArray, y: FloatArray, wanted_m: FloatArray, length_m: float, noise: float
) -> FloatArray:
    """Return the process's mean at wanted positions, from values y at others."""
    V = (1.0 - noise) * kernel(at_m, at_m, length_m) + noise * np.eye(len(y))
    result: FloatArray = (1.0 - noise) * kernel(wanted_m, at_m, length_m) @ np.linalg.solve(V, y)
    return result


def _without(base: MixedModelFit, runs: Runs) -> FloatArray:
    """Residuals (N,) of the base model fitted to all runs but these."""
    data, row_index = base.linear.data, base.problem.forward.row_index
    weights = base.solution.weights.copy()
    weights[runs] = 0.0
    WX = weights @ data.X
    A = np.einsum("rnp,rnq->pq", data.X, WX) + np.diag(data.precision)
    b = np.einsum("rnp,rn->p", WX, data.y) - data.precision * data.away
    left = data.y - data.X @ np.linalg.solve(A, b)
    result: FloatArray = left[row_index.run_of, row_index.row_of]
    return result
