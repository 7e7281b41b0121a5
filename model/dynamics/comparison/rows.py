"""One row a model: root mean squared errors of what it was not fitted to, and ln evidence."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from model.dynamics.comparison.measured import MeasuredRun, Noise, residuals
from model.dynamics.comparison.model_fit import FittedModel, fit_model
from model.dynamics.models import PublishedModel
from model.measurements import FloatArray, ModelError


@dataclass(frozen=True, kw_only=True)
class ComparisonRow:
    """A model on held-out data; NaN: it does not predict this, or nothing was held out."""

    title: str
    fitted: FittedModel | None  # None: `why` it was not fitted
    force_rmse_N: float = np.nan
    current_rmse_A: float = np.nan
    curve_rmse_m: float = np.nan
    ln_evidence: float = np.nan
    why: str = ""


def compare_models(
    models: Iterable[PublishedModel],
    fitted_to: Sequence[MeasuredRun],
    held_out: Sequence[MeasuredRun],
    noise: Noise,
) -> list[ComparisonRow]:
    """Fit each model to some runs and predict the others; the largest ln evidence comes first."""
    rows = [_row(one, fitted_to, held_out, noise) for one in models]
    return sorted(rows, key=lambda row: -np.nan_to_num(row.ln_evidence, nan=-np.inf))


def _row(
    model: PublishedModel,
    fitted_to: Sequence[MeasuredRun],
    held_out: Sequence[MeasuredRun],
    noise: Noise,
) -> ComparisonRow:
    try:
        fitted = fit_model(model, fitted_to, noise)
        off = [residuals(run, model.simulate(fitted.values, run.driven)) for run in held_out]
    except ModelError as error:
        return ComparisonRow(title=model.title, fitted=None, why=str(error))

    def rmse(name: str) -> float:
        return _rms([one[name].ravel() for one in off if name in one])

    return ComparisonRow(
        title=model.title, fitted=fitted, force_rmse_N=rmse("force"),
        current_rmse_A=rmse("current"), curve_rmse_m=rmse("curve"),
        ln_evidence=fitted.ln_evidence,
    )  # fmt: skip


def _rms(parts: list[FloatArray]) -> float:
    values = np.concatenate([np.zeros(0), *parts])
    good = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(good**2))) if len(good) else float("nan")
