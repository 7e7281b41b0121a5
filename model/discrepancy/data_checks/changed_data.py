"""Compare a configuration as stated with the same one after one value is changed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.quick_fit import QuickFit, Tolerances, fit_with, quick_fit
from model.measurements import Measurements

NEARLY_SETTLED = 1e-2  # relative fall of the squares: a change leaves a tenth of them, or is none
EXPLAINED_MISFIT = 3.0  # of a fit to which nothing can be added


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A change that was fitted."""

    check: str
    change: Change
    fit: QuickFit


@dataclass(frozen=True, kw_only=True)
class Compared:
    """A configuration's base fit, and those with one datum changed, the best one first."""

    name: str
    stated: QuickFit | None  # None: the model has no answer at all
    trials: tuple[Trial, ...]

    def share(self, trial: Trial) -> float:
        """Return what a change leaves of the squares; tolerated misfit counts on both sides."""
        if self.stated is None:
            return 0.0
        after, before = (one.squares + one.count for one in (trial.fit, self.stated))
        return after / before


def compared(
    name: str,
    data: Measurements,
    stated: QuickFit | None,
    tolerances: Tolerances,
    checks: Sequence[DataCheck],
) -> Compared:
    """Fit one configuration's bare data with each change that the checks propose.

    Those that need no more than a fit come first, and where one explains everything none follows.
    """
    changes = [(check.name, change) for check in checks for change in check.changes(data)]
    changes.sort(key=lambda one: one[1].continuous)
    found = list[Trial]()
    for check, change in changes:
        found += [
            Trial(check=check, change=change, fit=fit)
            for fit in _fits(data, change, tolerances, stated)
            if fit is not None and np.isfinite(fit.squares)
        ]
        if found and found[-1].fit.misfit < EXPLAINED_MISFIT:
            break
    found.sort(key=lambda one: one.fit.squares)
    return Compared(name=name, stated=stated, trials=tuple(found))


def _fits(
    data: Measurements, change: Change, tolerances: Tolerances, stated: QuickFit | None
) -> Iterator[QuickFit | None]:
    for value in change.values:
        if change.continuous and value == change.stated and stated is not None:
            begin: QuickFit | None = replace(stated, value=value)
        else:
            begin = quick_fit(change.apply(data, value), tolerances, value, NEARLY_SETTLED, stated)
        if not change.continuous:
            yield begin
            continue
        fit = fit_with(data, tolerances, change, begin, stated)
        if fit is not None and abs(fit.value - change.stated) >= change.least:
            yield fit


def of_one(measurements: Measurements, name: str) -> Measurements:
    """Return one configuration alone."""
    own = tuple(c for c in measurements.conditions if c.configuration == name)
    return replace(measurements, sheets={name: measurements.sheets[name]}, conditions=own)
