"""Gauss-Newton for one configuration with given weights: the start of a fit."""

from __future__ import annotations

import numpy as np

from model.identification.residual_vector import Predicted, System
from model.measurements import FloatArray, ModelError

MOST_STEPS = 30
ENOUGH = 1e-7  # relative fall of the sum of squares at which to stop


def gauss_newton(
    system: System,
    theta: FloatArray,
    force_sigma_N: float = 1e-4,
    mode_sigma_m: float = 1e-4,
    precision: FloatArray | None = None,
) -> tuple[FloatArray, Predicted]:
    """Parameters that minimise the weighted sum of squares (ridge `precision` about the start)."""
    start = theta.copy()
    ridge = np.zeros(len(theta)) if precision is None else precision
    found = system.predict(theta)
    residual, by = _rows(system, found, force_sigma_N, mode_sigma_m)
    value, damping = _value(residual, ridge, theta - start), 0.0
    for _ in range(MOST_STEPS):
        A = by.T @ by + np.diag(ridge)
        A[np.diag_indices(len(theta))] *= 1.0 + damping
        A[np.diag_indices(len(theta))] += 1e-12
        step = np.linalg.solve(A, by.T @ residual - ridge * (theta - start))
        step *= min(1.0, 2.0 / max(abs(float(step[0])), 1e-12))
        try:
            new = system.predict(theta + step)
        except ModelError:
            damping = max(10.0 * damping, 1e-2)
            if damping > 1e8:
                break
            continue
        rows = _rows(system, new, force_sigma_N, mode_sigma_m)
        better = _value(rows[0], ridge, theta + step - start)
        if better <= value * (1.0 + 1e-12):
            done = value - better <= ENOUGH * value
            theta, found, (residual, by), value = theta + step, new, rows, better
            damping *= 0.1 if damping > 1e-6 else 0.0
            if done:
                break
        else:
            damping = max(10.0 * damping, 1e-3)
            if damping > 1e8:
                break
    return theta, found


def _value(residual: FloatArray, ridge: FloatArray, away: FloatArray) -> float:
    return float(residual @ residual + ridge @ away**2)


def _rows(
    system: System, found: Predicted, force_sigma_N: float, mode_sigma_m: float
) -> tuple[FloatArray, FloatArray]:
    measured = np.array([o.force_N for o in system.observed.observations])
    use = np.isfinite(measured) & np.isfinite(found.force_N)
    curves = np.isfinite(found.modes_m).all(axis=1)
    residual = [
        (measured[use] - found.force_N[use]) / force_sigma_N,
        found.modes_m[curves].ravel() / mode_sigma_m,
    ]
    by = [
        found.force_by[use] / force_sigma_N,
        found.modes_by[curves].reshape(-1, system.layout.size) / mode_sigma_m,
    ]
    return np.concatenate(residual), np.concatenate(by)
