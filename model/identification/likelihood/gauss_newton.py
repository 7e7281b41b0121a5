"""Gauss-Newton with given weights: from rough parameters to where noise can be estimated."""

from __future__ import annotations

import numpy as np

from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import Bases, priors_of, sensitivities
from model.identification.likelihood.mixed_model import unsettled
from model.measurements import FloatArray, ModelError

FORCE_SIGMA_N, MODE_SIGMA_M = 1e-4, 1e-4  # what is weighed as one
MOST_STEPS, FEW_STEPS = 30, 2
ENOUGH = 1e-5  # relative fall of the sum of squares at which to stop
LONGEST_LOG_B = 2.0
LEAST_DAMPING, MOST_DAMPING = 1e-6, 1e8


def least_squares(
    forward: ForwardModel,
    bases: Bases,
    theta: FloatArray,
    enough: float = ENOUGH,
    worthless: float = np.inf,
) -> FloatArray:
    """Return the base parameters that minimise the weighted squares of forces, curves and priors.

    Damped after Levenberg and Marquardt where a step leads too far. It ends where a step takes
    less than the share `enough` from the squares. It is given up after `FEW_STEPS` where these are
    still above `worthless`, in units of `weighted_squares`. Raises ModelError where it leads
    nowhere.
    """
    mean, width = priors_of(bases)
    stiffness = [one.stiffness for one in bases.parts]
    weights = _weights(forward)
    precision, damping = width**-2.0, 0.0

    def rows(at: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        _, residual, columns = sensitivities(forward, bases, at)
        left = residual * weights
        return left, columns * weights[:, None], float(left @ left + precision @ (at - mean) ** 2)

    left, by, value = rows(theta)
    for number in range(MOST_STEPS):
        if number >= FEW_STEPS and value > worthless:
            break
        A = by.T @ by + np.diag(precision)
        A[np.diag_indices(len(theta))] *= 1.0 + damping
        try:
            step = np.linalg.solve(A, by.T @ left - precision * (theta - mean))
        except np.linalg.LinAlgError as error:
            raise unsettled() from error
        step *= min(1.0, LONGEST_LOG_B / max(float(np.max(np.abs(step[stiffness]))), 1e-12))
        try:
            there = rows(theta + step)
        except ModelError:
            there = left, by, np.inf
        if there[2] <= value * (1.0 + 1e-12):
            done = value - there[2] <= enough * value
            theta, (left, by, value) = theta + step, there
            damping *= 0.1 if damping > LEAST_DAMPING else 0.0
            if done:
                break
        else:
            damping = max(10.0 * damping, 1e-3)
            if damping > MOST_DAMPING:
                break
    return theta


def weighted_squares(forward: ForwardModel, residual: FloatArray) -> float:
    """Return the sum of squares of residuals (N,) of all rows, as `least_squares` weighs them."""
    return float(np.sum((residual * _weights(forward)) ** 2))


def _weights(forward: ForwardModel) -> FloatArray:
    """Return weights (N,), zero except for mean forces and curves."""
    weights = np.zeros(forward.row_index.size)
    for block, configuration_model in zip(
        forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        weights[block.trend_rows[block.is_mean]] = 1.0 / (FORCE_SIGMA_N * forward.scale.force)
        weights[block.mode_rows[configuration_model.has_curve]] = 1.0 / (
            MODE_SIGMA_M * forward.scale.length
        )
    return weights
