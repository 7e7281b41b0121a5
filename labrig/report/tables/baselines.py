"""Simpler models in use, compared with that of large deflections."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from labrig.report.data.models import ALONG, CONSTANT
from labrig.report.parts.table import Table, fixed, number, volts
from model.identification.baselines import BaselineRow

# the names that people see; those of JSON stay
_NAMES = {
    "full model, constant EIBM": f"large deflections, {CONSTANT}, refitted",
    "full model, EIBM along the sheet": f"large deflections, {ALONG}",
}


def baseline_table(rows: Sequence[BaselineRow]) -> Table:
    """One row for each configuration and model."""
    driven = sorted({v for row in rows for v in row.bend_per_m}, reverse=True)
    bends = tuple(f"Me/B at {volts(v)}, 1/m" for v in driven)
    columns = ("sheet, model", "B, µN·m²", *bends, "force RMSE, mN", "curve RMSE, mm")
    cells = tuple(
        (
            f"{row.configuration}: {_NAMES.get(row.model, row.model)}",
            number(1e6 * row.B_Nm2, 4),
            *(fixed(row.bend_per_m.get(v), 1) for v in driven),
            fixed(1e3 * row.force_rmse_N, 3),
            fixed(1e3 * row.curve_rmse_m, 3),
        )
        for row in rows
    )
    note = (
        "EIBM along the sheet: the joint fit. Model files: as they are, nothing refitted. All "
        "other rows: B and one EIBM for each voltage refitted to all forces and curves by least "
        "squares, k0 held. Me/B: of the constant EIBM (9); of a model file and of the equivalent "
        "beam the mean over [0, l]."
    )
    return Table(title="Comparison with simpler models", columns=columns, rows=cells, note=note)


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
