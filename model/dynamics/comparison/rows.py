"""One row a model: root mean squared errors of what it was not fitted to, and ln evidence."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from model.dynamics.comparison.compared_run import QUANTITIES, MeasuredRun, Quantity
from model.dynamics.comparison.contender import Contender
from model.dynamics.comparison.hold_out import HeldOut
from model.dynamics.comparison.model_fit import FittedModel, fit_model
from model.measurements import FloatArray, ModelError, Progress, silent

STEPS_ALONE = 6  # of a fit to one quantity, which begins at that to all of them


@dataclass(frozen=True, kw_only=True)
class QuantityScore:
    """How well a model does with one quantity."""

    rmse: float  # of what was held out and is predicted; N, A or m; NaN: nothing
    share: float  # of the values held out that the model predicts
    ln_evidence: float  # of all values that were fitted, fitted to this quantity alone


@dataclass(frozen=True, kw_only=True)
class ComparisonRow:
    """A model, fitted to some data and compared with others."""

    name: str
    title: str
    fitted: FittedModel | None  # None: `why` it was not fitted
    scores: dict[Quantity, QuantityScore] = field(default_factory=dict)  # of what it predicts
    ln_evidence: float = np.nan  # of everything, what it does not predict included
    why: str = ""


def compare_models(
    models: Sequence[Contender],
    data: HeldOut,
    begin: Callable[[Contender, Sequence[MeasuredRun]], dict[str, float] | None],
    progress: Progress = silent,
) -> list[ComparisonRow]:
    """Fit each model to some runs and predict the others; the largest ln evidence comes first.

    begin: where a model's fit to some runs begins; None: at its starting values.
    """
    rows = []
    for done, model in enumerate(models):
        progress(done / len(models), model.title)
        rows.append(_row(model, data, begin(model, data.fitted)))
    return sorted(rows, key=lambda row: -np.nan_to_num(row.ln_evidence, nan=-np.inf))


def _row(model: Contender, data: HeldOut, begin: dict[str, float] | None) -> ComparisonRow:
    try:
        fitted = fit_model(model, data.fitted, begin, refine=False)
        scores = dict(_scores(fitted, data))
    except ModelError as error:
        return ComparisonRow(name=model.name, title=model.title, fitted=None, why=str(error))
    return ComparisonRow(
        name=model.name, title=model.title, fitted=fitted, scores=scores,
        ln_evidence=fitted.ln_evidence,
    )  # fmt: skip


def _scores(fitted: FittedModel, data: HeldOut) -> Iterator[tuple[Quantity, QuantityScore]]:
    answers = [(run, fitted.model.respond(fitted.values, run)) for run in data.predicted]
    for quantity in QUANTITIES:
        if quantity not in fitted.misfit:
            continue
        alone = [run.only(quantity) for run in data.fitted if quantity in run.measured]
        refitted = fit_model(fitted.model, alone, fitted.values, most_steps=STEPS_ALONE)
        off, count = [np.zeros(0)], 0
        for run, response in answers:
            if quantity in run.measured:
                count += run.count(quantity)
                found = run.residuals(response, quantity)
                off.append(np.zeros(0) if found is None else found[np.isfinite(found)])
        rmse, predicted = _rms(np.concatenate(off))
        share = predicted / count if count else float("nan")
        yield quantity, QuantityScore(rmse=rmse, share=share, ln_evidence=refitted.ln_evidence)


def _rms(values: FloatArray) -> tuple[float, int]:
    return (float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")), len(values)
