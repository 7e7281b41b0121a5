"""Locate the residuals: forces, curves and signals that simulation does not match."""

from __future__ import annotations

from typing import Literal

import numpy as np

from model.discrepancy.thresholds import PLACE_SIGMA, PLACES_REPORTED
from model.discrepancy.verdict.prediction_error import refitted, variance
from model.discrepancy.verdict.result import Where
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.identification.likelihood.mixed_model import inverse_symmetric
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray

Observable = Literal["force", "curve", "signal"]


def staged(base: MixedModelFit) -> FloatArray:
    """Return residuals (N,) with B from 0 V alone, then the EIBM given B.

    They locate the misfit: a joint fit would spread an effect under voltage over all rows.
    """
    forward, problem, linear = base.problem.forward, base.problem, base.linear
    row_index = forward.row_index
    at_rest = np.zeros(row_index.size, dtype=bool)
    for block, configuration_model in zip(
        row_index.blocks, forward.configuration_models, strict=True
    ):
        zero = configuration_model.voltage_V == 0.0
        at_rest[block.trend_rows[zero[block.trend_of]]] = True
        rows = block.mode_rows[zero & configuration_model.has_curve]
        at_rest[rows.ravel()] = True
    if not at_rest.any() or at_rest.all():
        return refitted(base)
    stiff = np.zeros(linear.columns.shape[1], dtype=bool)
    for one in problem.bases.parts:
        stiff[[one.stiffness, *one.rest]] = True
    variance_ = variance(base)
    y = linear.residual.copy()
    for columns, rows in ((stiff, at_rest), (~stiff, ~at_rest)):
        X = linear.columns[rows][:, columns] / np.sqrt(variance_[rows])[:, None]
        A = X.T @ X + np.diag(linear.data.precision[columns])
        b = X.T @ (y[rows] / np.sqrt(variance_[rows]))
        y = y - linear.columns[:, columns] @ (inverse_symmetric(A) @ b)
    return y


def places(base: MixedModelFit, noise: FloatArray) -> tuple[Where, ...]:
    """Return the cells that exceed noise and scatter (variances (N,)), the strongest first."""
    residual, forward = staged(base), base.problem.forward
    z = residual / np.sqrt(noise)
    found: list[Where] = []
    for block, configuration_model in zip(
        forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        for i, (row, k) in enumerate(zip(block.trend_rows, block.trend_of, strict=True)):
            late = "in a first pulse" if block.is_early[i] else "how the readings go with time"
            detail = "" if block.is_mean[i] else late
            found.append(_where("force", configuration_model, k, float(z[row]), None, detail))
        for k in np.flatnonzero(configuration_model.has_curve).tolist():
            rows = block.mode_rows[k]
            off = configuration_model.along(k, residual[rows])
            at = float(configuration_model.curve_s[k, int(np.argmax(np.abs(off)))])
            found.append(_where("curve", configuration_model, k, _excess(z[rows]), at * 1e3))
        for row, k in zip(block.bin_rows, block.bin_of, strict=True):
            found.append(
                _where("signal", configuration_model, k, float(z[row]), None, "within the pulse")
            )
    found = [w for w in found if abs(w.z) >= PLACE_SIGMA]
    found.sort(key=lambda w: -abs(w.z))
    return tuple(found[:PLACES_REPORTED])


def _excess(z: FloatArray) -> float:
    """Return how far several numbers together stand out, in sigmas of one; 0: not clearly."""
    n, chi2 = len(z), float(np.sum(z**2))
    return float(np.sqrt(chi2 - n)) if chi2 > n + 3.0 * np.sqrt(2.0 * n) else 0.0


def _where(
    observable: Observable,
    configuration_model: ConfigurationModel,
    k: int,
    z: float,
    s_mm: float | None,
    detail: str = "",
) -> Where:
    at, name = float(configuration_model.stated_m[k]), configuration_model.sheet.configuration
    position = None if np.isnan(at) else round(at * 1e3, 6)
    return Where(
        observable=observable,
        configuration=name,
        voltage_V=float(configuration_model.voltage_V[k]),
        position_mm=position,
        s_mm=s_mm,
        z=z,
        detail=detail,
    )
