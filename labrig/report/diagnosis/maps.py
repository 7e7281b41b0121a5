"""Maps of where curves miss the simulation: over position, voltage and arc length."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from labrig.report.parts.style import INK, figure, label_of, letter
from model.discrepancy.verdict.result import Diagnosis, ErrorRow
from model.measurements import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = "RdBu_r"  # of signed residuals; for colour-blind readers too
_POINTS = 120  # along the sheet
_ROW_IN = 0.155
_NEXT_TO_NOTHING_MM = 1e-3


def residual_maps(found: Diagnosis) -> Figure | None:
    """Draw two maps for each configuration with curves: before and after, on one scale."""
    groups = [(n, rows) for n in configurations(found) if (rows := _ordered(found, n))]
    if not groups:
        return None
    heights = [max(6, len(rows)) * _ROW_IN for _, rows in groups]
    with figure(7.6, sum(heights) + 0.85 * len(groups)) as fig:
        panels = fig.subplots(len(groups), 2, squeeze=False, height_ratios=heights)
        for i, (name, rows) in enumerate(groups):
            before, after = (_map_mm(rows, when) for when in ("before", "after"))
            most = max(float(np.nanmax(np.abs(before))), _NEXT_TO_NOTHING_MM)
            for axes, values, what, mark in zip(
                panels[i], (before, after), ("before", "after"), "abcdefgh"[2 * i :], strict=False
            ):
                _draw(axes, values, rows, most)
                letter(axes, mark, f"{name} sheet, {what}")
            _label_rows(panels[i, 0], rows)
            panels[i, 1].set_yticks([])
            bar = fig.colorbar(panels[i, 1].images[0], ax=panels[i], pad=0.01, aspect=30)
            bar.set_label("measured − simulated (mm)")
            bar.outline.set_visible(False)
        for axes in panels[-1]:
            axes.set_xlabel("distance along the sheet s (mm)")
        return fig


def configurations(found: Diagnosis) -> list[str]:
    """In the order of the data."""
    return list(dict.fromkeys(row.configuration for row in found.rows))


def _ordered(found: Diagnosis, name: str) -> list[ErrorRow]:
    own = [r for r in found.rows if r.configuration == name and len(r.before_off_m)]
    return sorted(own, key=lambda r: (-r.voltage_V, r.position_m is None, r.position_m or 0.0))


def _map_mm(rows: list[ErrorRow], when: str) -> FloatArray:
    end = max(float(row.s_m[-1]) for row in rows)
    s = np.linspace(0.0, end, _POINTS)
    values = [np.interp(s, row.s_m, getattr(row, f"{when}_off_m"), right=np.nan) for row in rows]
    return 1e3 * np.array(values)


def _draw(axes: Axes, values: FloatArray, rows: list[ErrorRow], most: float) -> None:
    end_mm = 1e3 * max(float(row.s_m[-1]) for row in rows)
    axes.imshow(
        values, cmap=COLOURS, vmin=-most, vmax=most, aspect="auto", interpolation="nearest",
        extent=(0.0, end_mm, len(rows), 0.0),
    )  # fmt: skip
    axes.grid(visible=False)
    for edge in _edges(rows)[1:-1]:
        axes.axhline(edge, color=INK, linewidth=0.8)


def _edges(rows: list[ErrorRow]) -> list[int]:
    """Where one voltage ends and the next begins."""
    changes = [i for i in range(1, len(rows)) if rows[i].voltage_V != rows[i - 1].voltage_V]
    return [0, *changes, len(rows)]


def _label_rows(axes: Axes, rows: list[ErrorRow]) -> None:
    at = ["free" if r.position_m is None else f"{1e3 * r.position_m:g}" for r in rows]
    axes.set_yticks(np.arange(len(rows)) + 0.5, at, fontsize=6.5)
    axes.tick_params(axis="y", length=0)
    edges = _edges(rows)
    for low, high in pairwise(edges):
        axes.text(
            -0.12, 0.5 * (low + high), label_of(rows[low].voltage_V), rotation=90, ha="center",
            va="center", transform=axes.get_yaxis_transform(), fontsize=8,
        )  # fmt: skip
    axes.set_ylabel("position p (mm), by voltage")
    axes.yaxis.set_label_coords(-0.18, 0.5)
