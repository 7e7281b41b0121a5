"""Simpler models in use, compared with the full one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from labrig.report.parts.table import Table, fixed, number, volts
from model.identification.baselines import BaselineRow


def baseline_table(rows: Sequence[BaselineRow]) -> Table:
    """One row for each configuration and model."""
    driven = sorted({v for row in rows for v in row.bend_per_m}, reverse=True)
    bends = tuple(f"Me/B at {volts(v)}, 1/m" for v in driven)
    columns = ("sheet, model", "B, µN·m²", *bends, "force RMSE, mN", "curve RMSE, mm")
    cells = tuple(
        (
            f"{row.configuration}: {row.model}",
            number(1e6 * row.B_Nm2, 4),
            *(fixed(row.bend_per_m.get(v), 1) for v in driven),
            fixed(1e3 * row.force_rmse_N, 3),
            fixed(1e3 * row.curve_rmse_m, 3),
        )
        for row in rows
    )
    note = (
        "All but the model with the EIBM along the sheet, and model files, have B and one number "
        "for each voltage, fitted to all forces and curves by least squares."
    )
    return Table(title="Beside simpler models", columns=columns, rows=cells, note=note)


def baselines_as_list(rows: Sequence[BaselineRow]) -> list[dict[str, Any]]:
    """Return the same for `--json`."""
    return [
        {
            "configuration": row.configuration,
            "model": row.model,
            "B_Nm2": row.B_Nm2,
            "bend_per_m": {str(float(v)): bend for v, bend in row.bend_per_m.items()},
            "force_rmse_mN": 1e3 * row.force_rmse_N,
            "curve_rmse_mm": 1e3 * row.curve_rmse_m,
        }
        for row in rows
    ]
