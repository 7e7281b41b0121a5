"""Fit a published model to measured runs: bounded least squares of whitened residuals.

Unknowns are ln p of positive parameters, p of others, each over its prior scale, with its prior.
ln evidence: Laplace's approximation at the fitted values. What a model does not predict counts as
normal about its mean, with the mean and standard deviation of the data that are fitted, so that
models of different quantities are compared on the same data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.dynamics.comparison.measured import (
    MeasuredRun,
    Noise,
    correlations,
    measured_values,
    residuals,
    whitened,
)
from model.dynamics.models import ModelParameter, PublishedModel
from model.measurements import FloatArray, ModelError

NO_ANSWER = 1e3  # residual, in standard deviations, where a model has no solution
RELATIVE_STEP = 1e-5  # of the differences
LN_2PI = float(np.log(2.0 * np.pi))
SIGMA_DETERMINED = 0.5  # of a parameter's prior scale


@dataclass(frozen=True, kw_only=True)
class FittedModel:
    """A model with the values that fit best."""

    model: PublishedModel
    values: dict[str, float]
    sigma: dict[str, float]  # of ln p where positive, else of p; the prior included
    determined: frozenset[str]  # parameters that the data tell, not the prior
    ln_evidence: float
    chi2_per_value: float  # of what the model predicts


def fit_model(model: PublishedModel, runs: Sequence[MeasuredRun], noise: Noise) -> FittedModel:
    """Fit a model; `ModelError` where it predicts nothing that was measured."""
    from scipy.optimize import least_squares  # slow to import

    begin = np.array([_unknown(one, one.start) for one in model.parameters])
    low = np.array([_unknown(one, one.low) for one in model.parameters])
    high = np.array([_unknown(one, one.high) for one in model.parameters])
    first = _data(model, runs, noise, model.start())
    if not len(first):
        raise ModelError(f"the model '{model.name}' predicts nothing of what was measured")

    def misfit(x: FloatArray) -> FloatArray:
        try:
            data = _data(model, runs, noise, _values(model, x))
        except ModelError:
            data = np.full_like(first, NO_ANSWER)
        data = data if len(data) == len(first) else np.full_like(first, NO_ANSWER)
        return np.concatenate([data, x - begin])

    steps = np.full_like(begin, RELATIVE_STEP)
    found = least_squares(misfit, begin, bounds=(low, high), diff_step=steps, max_nfev=60)
    slopes = np.asarray(found.jac, dtype=float)
    precision = slopes.T @ slopes
    sigma = np.sqrt(np.diag(np.linalg.inv(precision)))
    chi2 = float(np.sum(found.fun[: len(first)] ** 2))
    evidence = -found.cost - 0.5 * float(np.linalg.slogdet(precision)[1])
    return FittedModel(
        model=model,
        values=_values(model, found.x),
        sigma={
            one.name: float(s * one.prior_scale)
            for one, s in zip(model.parameters, sigma, strict=True)
        },
        determined=frozenset(
            one.name for one, s in zip(model.parameters, sigma, strict=True) if s < SIGMA_DETERMINED
        ),
        ln_evidence=evidence + _constants(model, runs, noise),
        chi2_per_value=chi2 / len(first),
    )


def _unknown(of: ModelParameter, value: float) -> float:
    change = float(np.log(value / of.start)) if of.positive else value - of.start
    return change / of.prior_scale


def _values(model: PublishedModel, x: FloatArray) -> dict[str, float]:
    def value(of: ModelParameter, change: float) -> float:
        shifted = change * of.prior_scale
        exact = of.start * float(np.exp(shifted)) if of.positive else of.start + shifted
        return min(max(exact, of.low), of.high)

    return {one.name: value(one, float(at)) for one, at in zip(model.parameters, x, strict=True)}


def _sigma(noise: Noise, name: str) -> float:
    return {"force": noise.force_N, "current": noise.current_A, "curve": noise.curve_m}[name]


def _data(
    model: PublishedModel, runs: Sequence[MeasuredRun], noise: Noise, values: dict[str, float]
) -> FloatArray:
    """Return the whitened residuals of all that is measured and predicted."""
    parts = [np.zeros(0)]
    for run in runs:
        response = model.simulate(values, run.driven)
        for name, off in residuals(run, response).items():
            rho = None if name == "curve" else correlations(run, noise)
            parts.append(whitened(off, _sigma(noise, name), rho))
    return np.concatenate(parts)


def _constants(model: PublishedModel, runs: Sequence[MeasuredRun], noise: Noise) -> float:
    """Return the normalisation of the likelihood, and that of what is not predicted."""
    total = 0.0
    left_out: dict[str, list[FloatArray]] = {}
    for run in runs:
        off = residuals(run, model.simulate(model.start(), run.driven))
        for name, values in measured_values(run).items():
            there = np.isfinite(values)
            predicted = np.isfinite(off[name]) & there
            rho = None if name == "curve" else correlations(run, noise)
            spread = np.full(values.shape, _sigma(noise, name))
            if rho is not None:
                linked = np.concatenate([[False], np.isfinite(off[name][:-1])])
                spread = spread * np.sqrt(1.0 - np.where(linked, rho, 0.0) ** 2)
            total -= float(np.sum(np.log(spread[predicted]) + 0.5 * LN_2PI))
            left_out.setdefault(name, []).append(values[there & ~predicted])
    for name, parts in left_out.items():
        values = np.concatenate(parts)
        if len(values):
            spread_all = max(float(np.std(values)), _sigma(noise, name))
            total -= len(values) * (float(np.log(spread_all)) + 0.5 * LN_2PI)
            total -= 0.5 * float(np.sum((values - np.mean(values)) ** 2)) / spread_all**2
    return total
