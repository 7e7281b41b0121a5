"""Fit a model to runs: bounded least squares of whitened residuals, and its ln evidence.

Unknowns are ln p of positive parameters, p of others, each over its prior scale, with its prior.
No model is exact: where a quantity's residuals are larger than the noise explains, all of its noise
is taken as larger by one factor, the misfit, so that no quantity silences the others and a bad
prediction costs what it misleads by. ln evidence: Laplace's approximation at the fitted values.
What a model does not predict counts as normal about its mean, with the mean and standard deviation
of the data that are fitted, so that models of different runs are compared on the same data.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from model.dynamics.comparison.compared_run import LN_2PI, ComparedRun, Quantity
from model.dynamics.comparison.contender import Contender
from model.dynamics.models import ModelParameter
from model.measurements import FloatArray, ModelError

STEP = 1e-4  # of the differences, in prior scales
MISFIT_SIGMAS = 3.0  # residuals are larger than the noise explains from so many sigma on
ROUNDS = 4  # of a fit and the misfits that come of it
SAME_MISFIT = 0.05  # ends them
ENOUGH = 0.02  # gain of ln density that ends a search
MOST_STEPS = 30
SIGMA_DETERMINED = 0.5  # of a parameter's prior scale


@dataclass(frozen=True, kw_only=True)
class FittedModel:
    """A model with the values that fit best."""

    model: Contender
    values: dict[str, float]
    sigma: dict[str, float]  # of ln p where positive, else of p; the prior included
    determined: frozenset[str]  # parameters that the data tell, not the prior
    misfit: dict[Quantity, float]  # of what it predicts; 1: as the noise explains
    ln_evidence: float
    chi2_per_value: float  # of what the model predicts, by the noise alone


def fit_model(
    model: Contender,
    runs: Sequence[ComparedRun],
    begin: Mapping[str, float] | None = None,
    *,
    refine: bool = True,
    most_steps: int = MOST_STEPS,
) -> FittedModel:
    """Fit a model, from its starting values or from `begin`, in so many steps at most.

    refine: else `begin` is kept where it explains the data, as values of another fit to them do.
    `ModelError` where it predicts nothing that was measured.
    """
    problem = _Problem(model, runs)
    x = problem.unknowns(begin or {one.name: one.start for one in model.parameters})
    misfit = dict.fromkeys(problem.counts, 1.0)
    if not misfit:
        raise ModelError(f"the model '{model.name}' predicts nothing of what was measured")
    if begin and set(problem.misfits(x).values()) == {1.0} and not refine:
        return problem.fitted(x, misfit)
    for _ in range(ROUNDS):
        x = problem.least_squares(x, misfit, most_steps)
        before, misfit = misfit, problem.misfits(x)
        if all(abs(np.log(misfit[q] / before[q])) < SAME_MISFIT for q in misfit):
            break
    return problem.fitted(x, misfit)


class _Problem:
    """A model and runs."""

    def __init__(self, model: Contender, runs: Sequence[ComparedRun]) -> None:
        self.model, self.runs = model, runs
        self.counts: dict[Quantity, int] = {}  # of the values that are predicted
        start = {one.name: one.start for one in model.parameters}
        for of in self._residuals(start):
            if of.off is not None:
                count = int(np.isfinite(of.off).sum())
                if not count:
                    continue
                self.counts[of.quantity] = self.counts.get(of.quantity, 0) + count

    def unknowns(self, values: Mapping[str, float]) -> FloatArray:
        """Return x of parameters."""
        return np.array([_unknown(one, values[one.name]) for one in self.model.parameters])

    def values(self, x: FloatArray) -> dict[str, float]:
        """Return the parameters of x."""
        pairs = zip(self.model.parameters, x.tolist(), strict=True)
        return {one.name: _value(one, at) for one, at in pairs}

    def data(self, x: FloatArray) -> dict[Quantity, FloatArray]:
        """Return the whitened residuals of all that is measured and predicted."""
        parts: dict[Quantity, list[FloatArray]] = {q: [] for q in self.counts}
        for of in self._residuals(self.values(x)):
            if of.off is not None and of.quantity in parts:
                parts[of.quantity].append(of.run.whitened(of.off, of.quantity))
        return {q: np.concatenate(some) for q, some in parts.items()}

    def least_squares(
        self, x: FloatArray, misfit: Mapping[Quantity, float], most_steps: int
    ) -> FloatArray:
        """Return where the residuals over their misfits and the priors are least."""
        from scipy.optimize import least_squares  # slow to import

        low, high = (
            np.array([_unknown(one, getattr(one, end)) for one in self.model.parameters])
            for end in ("low", "high")
        )
        inside = np.clip(x, low + 2.0 * STEP, high - 2.0 * STEP)
        first = self._weighed(inside, misfit)
        enough = max(ENOUGH / (0.5 * float(first @ first) + 1.0), 1e-8)

        def weighed(at: FloatArray) -> FloatArray:
            try:
                return self._weighed(at, misfit)
            except ModelError:  # a step too far
                return np.full_like(first, np.inf)

        def slopes(at: FloatArray) -> FloatArray:
            return self.slopes(at, misfit)

        found = least_squares(
            weighed, inside, bounds=(low, high), max_nfev=most_steps, x_scale=1.0,
            jac=slopes, xtol=1e-6, ftol=enough,
        )  # fmt: skip
        return np.asarray(found.x)

    def slopes(self, x: FloatArray, misfit: Mapping[Quantity, float]) -> FloatArray:
        """Return d residuals/d x, (N, p), by forward differences."""
        at = self._weighed(x, misfit)
        columns = [(self._weighed(x + STEP * row, misfit) - at) / STEP for row in np.eye(len(x))]
        return np.stack(columns, axis=1)

    def misfits(self, x: FloatArray) -> dict[Quantity, float]:
        """Return the factors of the noise."""
        found = {}
        for quantity, off in self.data(x).items():
            count = self.counts[quantity]
            ratio = float(off @ off) / count
            explained = ratio < 1.0 + MISFIT_SIGMAS * np.sqrt(2.0 / count)
            found[quantity] = 1.0 if explained else float(np.sqrt(ratio))
        return found

    def fitted(self, x: FloatArray, misfit: dict[Quantity, float]) -> FittedModel:
        """Return the model with the values of x."""
        slopes, off = self.slopes(x, misfit), self._weighed(x, misfit)
        precision = slopes.T @ slopes
        sigma = np.sqrt(np.diag(np.linalg.inv(precision)))
        chi2 = sum(float(r @ r) for r in self.data(x).values())
        pairs = list(zip(self.model.parameters, sigma.tolist(), strict=True))
        evidence = -0.5 * float(off @ off) - 0.5 * float(np.linalg.slogdet(precision)[1])
        return FittedModel(
            model=self.model,
            values=self.values(x),
            sigma={one.name: s * one.prior_scale for one, s in pairs},
            determined=frozenset(one.name for one, s in pairs if s < SIGMA_DETERMINED),
            misfit=misfit,
            ln_evidence=evidence + self._constants(x, misfit),
            chi2_per_value=chi2 / sum(self.counts.values()),
        )

    def _weighed(self, x: FloatArray, misfit: Mapping[Quantity, float]) -> FloatArray:
        """Return residuals over their misfits, and the prior's."""
        return np.concatenate([*(off / misfit[q] for q, off in self.data(x).items()), x])

    def _constants(self, x: FloatArray, misfit: Mapping[Quantity, float]) -> float:
        """Return the normalisation of the likelihood, and that of what is not predicted."""
        total = 0.0
        left_out: dict[Quantity, list[FloatArray]] = {}
        for run, quantity, off in self._residuals(self.values(x)):
            values = run.values(quantity)
            missing = np.isfinite(values)
            if off is not None:
                missing &= ~np.isfinite(off)
                total += run.ln_density_at_0(off, quantity)
                total -= int(np.isfinite(off).sum()) * float(np.log(misfit[quantity]))
            left_out.setdefault(quantity, []).append(values[missing])
        for quantity, parts in left_out.items():
            total += _ln_normal(np.concatenate(parts), self.runs[0].least_sigma(quantity))
        return total

    def _residuals(self, values: Mapping[str, float]) -> Iterator[_Residuals]:
        for run in self.runs:
            response = self.model.respond(values, run)
            for quantity in run.measured:
                yield _Residuals(run, quantity, run.residuals(response, quantity))


class _Residuals(NamedTuple):
    """Of one quantity of one run."""

    run: ComparedRun
    quantity: Quantity
    off: FloatArray | None  # None: not predicted


def _ln_normal(values: FloatArray, least_sigma: float) -> float:
    """Return the log density of values about their own mean, with their own deviation."""
    if not len(values):
        return 0.0
    sigma = max(float(np.std(values)), least_sigma)
    away = float(np.sum((values - np.mean(values)) ** 2)) / sigma**2
    return -len(values) * (float(np.log(sigma)) + 0.5 * LN_2PI) - 0.5 * away


def _unknown(of: ModelParameter, value: float) -> float:
    change = float(np.log(value / of.start)) if of.positive else value - of.start
    return change / of.prior_scale


def _value(of: ModelParameter, unknown: float) -> float:
    shifted = unknown * of.prior_scale
    return of.start * float(np.exp(shifted)) if of.positive else of.start + shifted
