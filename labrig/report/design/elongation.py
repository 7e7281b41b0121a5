"""When an elongation pays: the map as a table, a figure and for `--json`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.report.parts.style import INK, figure, save
from labrig.report.parts.table import Table
from model.design.elongation_map import ElongationMap
from model.measurements import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_COLUMNS = 6


def elongation_table(name: str, found: ElongationMap) -> Table:
    """Return the ratio of the areas; a row for each beginning, a column for each end."""
    every = max(1, -(-len(found.high_m) // _MOST_COLUMNS))
    ends = range(len(found.high_m) - 1, -1, -every)[::-1]
    columns = ("from mm", *(f"to {1e3 * found.high_m[j]:.4g}" for j in ends))
    rows = tuple(
        (f"{1e3 * found.low_m[i]:.4g}", *(_cell(found.ratio[i, j]) for j in ends))
        for i in range(0, len(found.low_m), every)
    )
    return Table(
        title=f"8. {name}: least area with an elongation over that without",
        columns=columns,
        rows=rows,
        note="Below 1 an elongation pays, for every force. 0: possible only with one.",
    )


def _cell(ratio: float) -> str:
    if np.isnan(ratio):
        return "-"
    return f"{ratio:.2f}" if np.isfinite(ratio) else "without"


def as_dict(found: ElongationMap) -> dict[str, Any]:
    """Return the map for `--json`, in SI; null where there is no section or no sheet."""
    return {
        "low_m": found.low_m.tolist(), "high_m": found.high_m.tolist(),
        "alone_m2_per_N": _plain(found.alone_m2_per_N),
        "elongated_m2_per_N": _plain(found.elongated_m2_per_N),
    }  # fmt: skip


def _plain(values: FloatArray) -> list[list[float | None]]:
    return [[float(v) if np.isfinite(v) else None for v in row] for row in values]


def draw_elongation_map(name: str, found: ElongationMap, path: Path) -> None:
    """Write the figure of the map."""
    with figure(5.0, 4.0) as fig:
        draw_map(fig.subplots(), name, found)
        save(fig, path)


def draw_map(axes: Axes, name: str, found: ElongationMap) -> None:
    """Draw the ratio of the areas over beginning and end of the section."""
    ratio = np.ma.masked_invalid(np.clip(found.ratio, 0.0, 2.0))
    low, high = 1e3 * found.low_m, 1e3 * found.high_m
    drawn = axes.pcolormesh(
        low, high, ratio.T, cmap="RdBu_r", vmin=0.0, vmax=2.0, shading="nearest"
    )
    if float(ratio.min()) < 1.0 < float(ratio.max()):
        axes.contour(low, high, ratio.T, [1.0], colors=INK)
    fig = axes.get_figure()
    if fig is not None:
        fig.colorbar(drawn, ax=axes, label="area with over area without elongation")
    axes.set(xlabel="beginning of the section (mm)", ylabel="end of the section (mm)")
    axes.set_title(f"{name}: blue, an elongation pays", loc="left")
    axes.grid(visible=False)
