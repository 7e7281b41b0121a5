"""Fits all configurations whose data allow it, and states why the others are left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from labrig.report.data.models import Models
from labrig.report.data.selection import configurations
from model import Fit, FitOptions, Measurements, ModelError, fit


@dataclass(frozen=True)
class FittedSheets:
    """A fit of all configurations that allow one, and why the others do not."""

    fit: Fit | None
    missing: Mapping[str, str] = field(default_factory=dict)  # configuration -> one sentence

    @property
    def models(self) -> Models | None:
        """Both simulations."""
        return None if self.fit is None else Models(self.fit.varying_model, self.fit.model)


def fit_what_can_be(measurements: Measurements, options: FitOptions | None = None) -> FittedSheets:
    """Fit all configurations together, or those for which that is possible."""
    options = options or FitOptions()
    names = options.configurations or configurations(measurements)
    try:
        return FittedSheets(fit(measurements, options))
    except ModelError as error:
        if len(names) < 2:
            return FittedSheets(None, dict.fromkeys(names, str(error)))
    missing = {name: _why_not(measurements, options, name) for name in names}
    good = tuple(name for name, why in missing.items() if not why)
    lacking = {name: why for name, why in missing.items() if why}
    if not good:
        return FittedSheets(None, lacking)
    return FittedSheets(fit(measurements, replace(options, configurations=good)), lacking)


def _why_not(measurements: Measurements, options: FitOptions, name: str) -> str:
    try:
        fit(measurements, replace(options, configurations=(name,)))
    except ModelError as error:
        return str(error)
    return ""
