"""How a fit predicts the conditions that were left out of it."""

from __future__ import annotations

from dataclasses import replace

from labrig.report.data.models import ALONG, CONSTANT, HELD, knows
from labrig.report.parts.table import Table, fixed
from labrig.report.tables.fit import against_table
from model import Fit, Measurements
from model.identification.observations import observe
from model.identification.residuals import ConditionResidual, residuals, rmse


def left_out_rows(fit: Fit, measurements: Measurements) -> tuple[ConditionResidual, ...]:
    """Each condition left out that the fit has an answer for and whose readings count."""
    held = tuple(
        c
        for c in measurements.conditions
        if fit.options.holds_out(c) and knows(fit.model, c.configuration, c.voltage_V) and c.used()
    )
    names = [n for n in fit.configurations if any(c.configuration == n for c in held)]
    observed = [observe(replace(measurements, conditions=held), name) for name in names]
    return residuals(observed, fit.model, fit.varying_model)


def left_out_table(rows: tuple[ConditionResidual, ...]) -> Table:
    """Predictions of what was left out against what was measured there."""
    table = against_table("Predictions at left-out positions", rows)
    along, constant = rmse(rows, "varying"), rmse(rows, "constant")
    note = (
        f"RMS errors: {ALONG} {fixed(1e3 * along.force_N, 3)} mN and "
        f"{fixed(1e3 * along.curve_m, 3)} mm, {CONSTANT} {fixed(1e3 * constant.force_N, 3)} mN"
        f" and {fixed(1e3 * constant.curve_m, 3)} mm. {HELD}"
    )
    return replace(table, note=note)
