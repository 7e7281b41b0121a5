"""How well a model predicts positions that are left out of its fit, family by family.

With P = W - W X (X'WX)^-1 X'W of the whole data, the residual of left-out rows g is
    e_g = P_gg^-1 (P y)_g    with covariance    P_gg^-1,
so that nothing is fitted again (Rasmussen and Williams 2006, Gaussian Processes, eq. 5.12).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.identification.data.data_vector import Index
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray

DETERMINED = 1e-10  # of the largest weight: below it rows alone fix a parameter


@dataclass(frozen=True)
class Predictive:
    """Left-out residuals of a model at given scatter."""

    fitted: MixedModelFit
    log_sigma: FloatArray
    groups: Sequence[Index]  # runs that are left out together

    @cached_property
    def _whole(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """P (N, N), P y (N,), and the weights of single rows (N,)."""
        row_index, linear = self.fitted.problem.forward.row_index, self.fitted.linear
        solution = weigh(linear.data, self.log_sigma)
        W = np.zeros((row_index.size, row_index.size))
        for r, own in enumerate(solution.weights):
            rows = np.flatnonzero(row_index.run_of == r)
            W[np.ix_(rows, rows)] = own[np.ix_(row_index.row_of[rows], row_index.row_of[rows])]
        WX = W @ linear.columns
        P = W - WX @ solution.covariance @ WX.T
        return P, W @ (linear.residual - linear.columns @ solution.beta), np.diag(W)

    def left_out(self, rows: Index) -> tuple[FloatArray, FloatArray]:
        """Return the residual of rows that are left out together, and its covariance."""
        P, Py, weight = self._whole
        D, U = np.linalg.eigh(P[np.ix_(rows, rows)])
        known = DETERMINED * float(np.max(weight[rows])) < D
        D, U = D[known], U[:, known]
        return U @ ((U.T @ Py[rows]) / D), (U / D) @ U.T

    @cached_property
    def residuals(self) -> list[tuple[Index, FloatArray, FloatArray]]:
        """Rows, residual and covariance of each group."""
        run_of = self.fitted.problem.forward.row_index.run_of
        every = [np.flatnonzero(np.isin(run_of, runs)) for runs in self.groups]
        return [(rows, *self.left_out(rows)) for rows in every]

    def chi2(self, wanted: Index) -> tuple[float, int]:
        """Return chi^2 of some rows, each left out with its position, and how many there are."""
        total, count = 0.0, 0
        for rows, residual, covariance in self.residuals:
            own = np.flatnonzero(np.isin(rows, wanted))
            if len(own):
                V = covariance[np.ix_(own, own)]
                total += float(residual[own] @ np.linalg.lstsq(V, residual[own], rcond=None)[0])
                count += len(own)
        return total, count
