"""Forces and curves, measured and simulated before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from labrig.report.diagnosis.maps import configurations
from labrig.report.parts.style import (
    ALONG_COLOUR,
    CONSTANT_COLOUR,
    INK,
    colour_of,
    figure,
    label_of,
    legend_below,
    letter,
    panels_width_in,
)
from model.discrepancy.verdict.result import Diagnosis, ErrorRow

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DASHED = (0, (4, 2.5))
_MARKS = 30  # measured points that are drawn of a curve
_REACH = 1.645  # standard uncertainties to either side: 90 %


def at_set_ups(found: Diagnosis) -> bool:
    """Whether the diagnosis holds the models at the estimated offsets of each set-up."""
    return any(np.isfinite(r.after_at_setup_N) or r.after_at_setup_xy_m for r in found.rows)


def drawn_force_N(row: ErrorRow, when: str) -> float:
    """Return the force of a line: at the estimated offsets of its set-up, where these are known."""
    offset, nominal = (float(getattr(row, f"{when}_{kind}")) for kind in ("at_setup_N", "N"))
    return offset if np.isfinite(offset) else nominal


def forces_figure(found: Diagnosis) -> Figure | None:
    """Draw forces over positions, and below their residuals, for each configuration."""
    names = [n for n in configurations(found) if _held(found, n)]
    if not names:
        return None
    with figure(panels_width_in(len(names)), 5.0) as fig:
        panels = fig.subplots(2, len(names), squeeze=False, height_ratios=[1.5, 1.0], sharex="col")
        for column, name, mark in zip(panels.T, names, "abcdefgh", strict=False):
            draw_forces_before_and_after(column[0], found, name)
            for own in _by_voltage(found, name):
                _left(column[1], own, _colour(found, own[0]))
            letter(column[0], mark, f"{name} sheet")
            column[1].axhline(0, color=INK, linewidth=0.7, alpha=0.6)
            column[1].set_xlabel("position p (mm)")
        panels[0, 0].set_ylabel("force F (mN)")
        panels[1, 0].set_ylabel("measured − simulated (mN)")
        _legend(fig, panels[0, 0])
        return fig


def draw_forces_before_and_after(axes: Axes, found: Diagnosis, name: str) -> None:
    """Draw measured forces over position, and those simulated before (dashed) and after."""
    for own in _by_voltage(found, name):
        _forces(axes, own, _colour(found, own[0]))


def _by_voltage(found: Diagnosis, name: str) -> list[list[ErrorRow]]:
    """Return the conditions of a configuration, those of the highest voltage first."""
    rows = _held(found, name)
    volts = sorted({row.voltage_V for row in rows}, reverse=True)
    return [[row for row in rows if row.voltage_V == one] for one in volts]


def _held(found: Diagnosis, name: str) -> list[ErrorRow]:
    own = [r for r in found.rows if r.configuration == name and r.position_m is not None]
    kept = [r for r in own if np.isfinite(r.force_N)]
    return sorted(kept, key=lambda r: (r.voltage_V, r.position_m or 0.0))


def _colour(found: Diagnosis, row: ErrorRow) -> str:
    return colour_of(row.voltage_V, [each.voltage_V for each in found.rows])


def _forces(axes: Axes, rows: list[ErrorRow], colour: str) -> None:
    p = [1e3 * (r.position_m or 0.0) for r in rows]
    axes.plot(
        p, [1e3 * r.force_N for r in rows], "o", markersize=3.4, color=colour, zorder=3,
        label=label_of(rows[0].voltage_V),
    )  # fmt: skip
    for when, style in (("before", DASHED), ("after", "-")):
        values = [1e3 * drawn_force_N(r, when) for r in rows]
        axes.plot(p, values, color=colour, linestyle=style, linewidth=1.1)


def _left(axes: Axes, rows: list[ErrorRow], colour: str) -> None:
    p = [1e3 * (r.position_m or 0.0) for r in rows]
    before = [1e3 * (r.force_N - r.before_N) for r in rows]
    after = [1e3 * (r.force_N - r.after_N) for r in rows]
    axes.plot(p, before, color=colour, linestyle=DASHED, linewidth=0.9)
    bars = [1e3 * _REACH * r.sigma_N for r in rows]
    axes.errorbar(
        p, after, yerr=bars, fmt="o", markersize=3.0, capsize=2.0, elinewidth=0.9, linewidth=0,
        color=colour,
    )  # fmt: skip


def _legend(fig: Figure, axes: Axes) -> None:
    from matplotlib.lines import Line2D

    handles = list(axes.get_legend_handles_labels()[0])
    handles += [
        Line2D([], [], color=INK, linewidth=1.1, linestyle=DASHED, label="before"),
        Line2D([], [], color=INK, linewidth=1.1, label="after"),
    ]
    legend_below(fig, handles)


def curves_figure(found: Diagnosis) -> Figure | None:
    """Of each configuration, the curves of the position that was missed most."""
    chosen = [(n, rows) for n in configurations(found) if (rows := _worst(found, n))]
    if not chosen:
        return None
    with figure(panels_width_in(len(chosen)), 3.9) as fig:
        panels = fig.subplots(1, len(chosen), squeeze=False)[0]
        for axes, (name, rows), mark in zip(panels, chosen, "abcdefgh", strict=False):
            for row in rows:
                _curve(axes, row, _colour(found, row))
            p = rows[0].position_m
            at = "free" if p is None else f"p = {1e3 * p:g} mm"
            letter(axes, mark, f"{name} sheet, {at}")
            axes.set_xlabel("x (mm)")
        panels[0].set_ylabel("y (mm), enlarged")
        shown = {r.voltage_V: _colour(found, r) for _, rows in chosen for r in rows}
        _curve_legend(fig, dict(sorted(shown.items(), reverse=True)))
        return fig


def _worst(found: Diagnosis, name: str) -> list[ErrorRow]:
    """All voltages of the position whose curve was missed most."""
    own = [r for r in found.rows if r.configuration == name and len(r.before_off_m)]
    if not own:
        return []
    worst = max(own, key=lambda r: float(np.mean(r.before_off_m**2)))
    return [r for r in own if r.position_m == worst.position_m]


def _curve(axes: Axes, row: ErrorRow, colour: str) -> None:
    thin = np.unique(np.linspace(0, len(row.x_m) - 1, _MARKS).round().astype(int))
    axes.plot(
        1e3 * row.x_m[thin], 1e3 * row.y_m[thin], "o", markersize=3.4, markerfacecolor="none",
        markeredgewidth=0.8, color=colour,
    )  # fmt: skip
    for (x, y), simulated, style in (
        (row.before_at_setup_xy_m or row.before_xy_m, CONSTANT_COLOUR, DASHED),
        (row.after_at_setup_xy_m or row.after_xy_m, ALONG_COLOUR, "-"),
    ):
        axes.plot(1e3 * x, 1e3 * y, color=simulated, linestyle=style, linewidth=1.3)


def _curve_legend(fig: Figure, colours: dict[float, str]) -> None:
    from matplotlib.lines import Line2D

    legend_below(
        fig,
        [
            *(
                Line2D(
                    [], [], color=colour, linewidth=0, marker="o", markersize=3.4,
                    markerfacecolor="none", label=f"measured, {label_of(v)}",
                )
                for v, colour in colours.items()
            ),
            Line2D([], [], color=CONSTANT_COLOUR, linestyle=DASHED, linewidth=1.3, label="before"),
            Line2D([], [], color=ALONG_COLOUR, linewidth=1.3, label="after"),
        ],
    )  # fmt: skip
