"""Compute how much of a fitted effect is deviation from the catalogue's form."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from model.discrepancy.verdict.prediction_error import variance
from model.effects.interface import Effect
from model.identification.likelihood.form_error import whole_step
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.locations.quantities import Perturbation
from model.measurements import FloatArray

IN_TIME = frozenset({"time", "session", "wetted", "run"})


def in_time(effect: Effect) -> bool:
    """Return whether its form may differ in time."""
    return bool(IN_TIME.intersection(effect.form_error_along))


def form_share(fitted: MixedModelFit, index: int) -> float:
    """Return the share of an effect's squared contribution that its form alone cannot make.

    `index` is its place among the effects found. What goes by the side of approach at 0 V is no
    matter of the form: its size is any there.
    """
    one, span, forward = fitted.found[index], fitted.spans[index], fitted.problem.forward
    steps = steps_of(fitted, index)
    if not steps:
        return 0.0
    rows = [forward.rows_of(c, fitted.linear.states[c], step) for c, step in steps]
    if "approach" in one.effect.form_error_along:
        rows += [np.where(at_zero(forward), row, 0.0) for row in rows]
    free = slice(span.start + len(one.parameters()), span.stop)
    deviation = fitted.linear.columns[:, free] @ fitted.solution.beta[free]
    return _share(fitted, np.stack(rows, axis=1), deviation)


def at_zero(forward: ForwardModel) -> npt.NDArray[np.bool_]:
    """Return which rows are of conditions at 0 V, (N,)."""
    result = np.zeros(forward.row_index.size, dtype=bool)
    for block, configuration_model in zip(
        forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        zero = configuration_model.voltage_V == 0.0
        result[block.trend_rows[zero[block.trend_of]]] = True
        result[block.mode_rows[zero & configuration_model.has_curve].ravel()] = True
    return result


def steps_of(fitted: MixedModelFit, index: int) -> list[tuple[int, Perturbation]]:
    """Return the perturbation by the effect in each configuration that has it."""
    one, forward = fitted.found[index], fitted.problem.forward
    others = tuple(f.active for f in fitted.found if f is not one)
    result = []
    for c, name in enumerate(forward.names):
        if name in one.values:
            state = fitted.linear.states[c]
            result.append((c, whole_step(forward, c, state, state.base, others, one.active)))
    return result


def _share(fitted: MixedModelFit, whole: FloatArray, deviation: FloatArray) -> float:
    """Return the share of a contribution that no amplitude per configuration can make."""
    by = 1.0 / np.sqrt(variance(fitted))
    own = np.stack([w - _on_base(fitted, w) for w in whole.T], axis=1) * by[:, None]
    total = own.sum(axis=1) + (deviation - _on_base(fitted, deviation)) * by
    size = np.linalg.lstsq(own, total, rcond=1e-9)[0]
    square = float(total @ total)
    return float(np.sum((total - own @ size) ** 2) / square) if square > 0.0 else 0.0


def _on_base(fitted: MixedModelFit, column: FloatArray) -> FloatArray:
    """Return the part of a column that the base parameters can take up."""
    size, forward = fitted.problem.bases.size, fitted.problem.forward
    row_index, W = forward.row_index, fitted.solution.weights
    X = row_index.pad(fitted.linear.columns[:, :size])
    p = X.shape[2]
    A = X.reshape(-1, p).T @ (W @ X).reshape(-1, p) + np.diag(fitted.linear.data.precision[:size])
    b = X.reshape(-1, p).T @ (W @ row_index.pad(column)[:, :, None])[:, :, 0].ravel()
    result: FloatArray = fitted.linear.columns[:, :size] @ np.linalg.lstsq(A, b, rcond=1e-12)[0]
    return result
