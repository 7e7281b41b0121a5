"""Cross-validate models on positions that were left out of choosing and fitting them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from model.discrepancy.search.evidence import Candidate, Projected, Score, scored
from model.discrepancy.verdict.prediction_error import refitted
from model.identification.data.data_vector import Index
from model.identification.likelihood.mixed_model import inverse_symmetric, weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray
from model.sheet.free_effect import FreeEffect


def left_out(
    base: MixedModelFit,
    final: MixedModelFit,
    pool: Sequence[Candidate],
    groups: list[Index],
    alike: Collection[str] = (),
) -> tuple[FloatArray, FloatArray, list[str]]:
    """Return residuals of rows when they are left out, and what was chosen each time.

    Those of the base model, and those of the model that is chosen without them, (N,) each.

    The choice is repeated among `pool` each time; where it is one of the final model's effects,
    or one of the names `alike`, in whose place it has its own, that model's columns predict what
    was left out. Rows that are in no group stay as they are fitted.
    """
    before, after = refitted(base).copy(), refitted(final).copy()
    new = final.found[len(base.found) :]
    # what is in no catalogue is no choice among names
    own = {one.effect.name for one in new if not isinstance(one.effect, FreeEffect)}
    own |= {*alike} if own else set()
    chosen = list[str]()
    # with the base model's own noise, scatter would pass for what an effect does in every set-up
    judge = replace(base, solution=weigh(base.linear.data, final.solution.log_sigma))
    for runs in groups:
        rows = np.flatnonzero(np.isin(base.problem.forward.row_index.run_of, runs))
        before[rows] = _predicted(base, base.linear.columns, runs)[rows]
        best = best_without(judge, pool, runs) if own and pool else None
        name = "" if best is None or best.log_bayes <= 0.0 else best.candidate.name
        if final is base or (own and not name):
            after[rows] = before[rows]
        elif best is None or name in own:
            after[rows] = _predicted(final, final.linear.columns, runs)[rows]
        else:
            columns = np.concatenate([base.linear.columns, best.candidate.columns], axis=1)
            extra = np.full(best.candidate.columns.shape[1], best.scale**-2.0)
            after[rows] = _predicted(judge, columns, runs, extra)[rows]
        chosen.append(name)
    return before, after, chosen


def when_left_out(fitted: MixedModelFit) -> FloatArray:
    """Return the residual of each row with its position left out of the fit, (N,)."""
    none = np.zeros(0, dtype=np.int64)
    residual, of = (
        _predicted(fitted, fitted.linear.columns, none), fitted.problem.forward.row_index.run_of
    )  # fmt: skip
    for runs in position_groups(fitted):
        rows = np.isin(of, runs)
        residual[rows] = _predicted(fitted, fitted.linear.columns, runs)[rows]
    return residual


def _information(
    fitted: MixedModelFit, columns: FloatArray, runs: Index, extra: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """Return the normal equations of all runs except `runs`."""
    data, row_index = fitted.linear.data, fitted.problem.forward.row_index
    kept = np.setdiff1d(np.arange(len(row_index.runs)), runs)
    X = row_index.pad(columns)[kept]
    W, y = fitted.solution.weights[kept], row_index.pad(fitted.linear.residual)[kept]
    WX = W @ X
    precision, away = data.precision, data.away
    if extra is not None:
        precision = np.concatenate([precision, extra])
        away = np.concatenate([away, np.zeros(len(extra))])
    p = X.shape[2]
    A = X.reshape(-1, p).T @ WX.reshape(-1, p) + np.diag(precision)
    return A, WX.reshape(-1, p).T @ y.ravel() - precision * away


def _predicted(
    fitted: MixedModelFit, columns: FloatArray, runs: Index, extra: FloatArray | None = None
) -> FloatArray:
    """Return residuals of everything when the parameters come from all runs but these."""
    A, b = _information(fitted, columns, runs, extra)
    result: FloatArray = fitted.linear.residual - columns @ (inverse_symmetric(A) @ b)
    return result


def predictive_gains(before: MixedModelFit, after: MixedModelFit) -> FloatArray:
    """Ln of how much more likely each position's data are in the second model than in the first.

    The position is left out of both fits.
    """
    groups = position_groups(before)
    return np.array([_likely(after, runs) - _likely(before, runs) for runs in groups])


def _likely(fitted: MixedModelFit, runs: Index) -> float:
    """Return ln of the density of some runs' data as the others predict them, but for a constant.

    What the others do not know, such as how a form differs in just these runs, is as unsure as it
    was beforehand.
    """
    row_index = fitted.problem.forward.row_index
    A, b = _information(fitted, fitted.linear.columns, runs, None)
    covariance = inverse_symmetric(A)
    X = row_index.pad(fitted.linear.columns)[runs]
    error = (row_index.pad(fitted.linear.residual)[runs] - X @ (covariance @ b)).ravel()
    V = np.einsum("rip,pq,sjq->risj", X, covariance, X, optimize=True)
    for r, weights in enumerate(fitted.solution.weights[runs]):
        V[r, :, r, :] += np.linalg.inv(weights)
    V = V.reshape(len(error), len(error))
    return -0.5 * float(np.linalg.slogdet(V)[1] + error @ np.linalg.solve(V, error))


def best_without(base: MixedModelFit, pool: Sequence[Candidate], runs: Index) -> Score:
    """Return the candidate that the other runs choose, with the noise as it was found."""
    return max(scores_without(base, pool, runs), key=lambda s: s.log_bayes)


def scores_without(base: MixedModelFit, pool: Sequence[Candidate], runs: Index) -> list[Score]:
    """Return the evidence of each candidate in the other runs, with the noise as it was found."""
    forward, row_index = base.problem.forward, base.problem.forward.row_index
    weights = base.solution.weights.copy()
    weights[runs] = 0.0
    A, b = _information(base, base.linear.columns, runs, None)
    covariance = inverse_symmetric(A)
    error = row_index.pad(base.linear.residual - base.linear.columns @ (covariance @ b))
    We = (weights @ error[:, :, None])[:, :, 0]
    WX = (weights @ base.linear.data.X)[row_index.run_of, row_index.row_of]
    projected = Projected(weights, WX, covariance, We[row_index.run_of, row_index.row_of])
    return scored(forward, projected, pool)


def left_out_rows(fitted: MixedModelFit) -> Index:
    """Return the rows that are left out in turn: those of positions, and not of free shapes."""
    groups = position_groups(fitted)
    if not groups:
        return np.zeros(0, dtype=np.int64)
    run_of = fitted.problem.forward.row_index.run_of
    return np.flatnonzero(np.isin(run_of, np.concatenate(groups)))


def position_groups(fitted: MixedModelFit) -> list[Index]:
    """Return runs grouped by position over all configurations; free shapes are never left out."""
    groups: dict[float, list[int]] = {}
    for r, run in enumerate(fitted.problem.forward.row_index.runs):
        if np.isfinite(run[1]):
            groups.setdefault(round(run[1], 7), []).append(r)
    return [np.array(g, dtype=np.int64) for g in groups.values()]
