"""Forces against position, measured and simulated (figure 9)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from labrig.report.data.models import ALONG, CONSTANT, Models, force_curve_N, knows
from labrig.report.data.selection import conditions_of, mean_forces, positions_m, voltages
from labrig.report.parts.style import (
    INK,
    colour_of,
    figure,
    label_of,
    legend_below,
    letter,
    panels_width_in,
)
from model import Measurements, SheetModel
from model.measurements import FloatArray, length_scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LINES = {ALONG: "-", CONSTANT: (0, (4, 2.5))}
# of sheets of the paper's size
_BEYOND_M = 1e-3  # simulated lines go on beyond the outer positions
_STEP_M = 0.5e-3


def force_figure(measurements: Measurements, names: list[str], models: Models | None) -> Figure:
    """Figure 9: means with the standard deviation of their readings, and simulated lines."""
    with figure(panels_width_in(len(names)), 3.7) as fig:
        panels = fig.subplots(1, len(names), squeeze=False)[0]
        for axes, name, mark in zip(panels, names, "abcdefgh", strict=False):
            draw_forces(axes, measurements, name, models.named() if models is not None else ())
            letter(axes, mark, f"{name} sheet")
        panels[0].set_ylabel("force F (mN)")
        _legend(fig, models is not None)
        return fig


def draw_forces(
    axes: Axes, measurements: Measurements, name: str, simulated: Sequence[tuple[str, SheetModel]]
) -> None:
    """Draw the forces of a configuration over position; simulated ones by the name of a model."""
    axes.axhline(0, color=INK, linewidth=0.7, alpha=0.6)
    for volts in voltages(measurements, name):
        _measured(axes, measurements, name, volts)
        colour = colour_of(volts, voltages(measurements, name))
        _simulated(axes, simulated, name, volts, _range(measurements, name), colour)
    _invalid(axes, measurements, name)
    axes.set_xlabel("position p (mm)")


def _measured(axes: Axes, measurements: Measurements, name: str, volts: float) -> None:
    forces = mean_forces(measurements, name, volts)
    if not forces:
        return
    axes.errorbar(
        [1e3 * f.position_m for f in forces],
        [1e3 * f.mean_N for f in forces],
        yerr=[0.0 if np.isnan(f.deviation_N) else 1e3 * f.deviation_N for f in forces],
        fmt="o",
        markersize=3.2,
        capsize=2.5,
        linewidth=0,
        elinewidth=1.0,
        color=colour_of(volts, voltages(measurements, name)),
        label=label_of(volts),
        zorder=3,
    )


def _range(measurements: Measurements, name: str) -> FloatArray:
    places = positions_m(measurements, name)
    if not places:
        return np.empty(0)
    scale = length_scale(measurements.sheets[name])
    low, high = places[0] - _BEYOND_M * scale, places[-1] + _BEYOND_M * scale
    return np.linspace(low, high, max(2, round((high - low) / (_STEP_M * scale)) + 1))


def _simulated(
    axes: Axes,
    models: Sequence[tuple[str, SheetModel]],
    name: str,
    volts: float,
    places_m: FloatArray,
    colour: str,
) -> None:
    for kind, model in models:
        if knows(model, name, volts) and len(places_m):
            force = force_curve_N(model, name, places_m, volts)
            axes.plot(
                1e3 * places_m, 1e3 * force, color=colour, linewidth=1.1, linestyle=_LINES[kind]
            )


def _invalid(axes: Axes, measurements: Measurements, name: str) -> None:
    """Mark invalid readings with crosses, where all of their condition are invalid."""
    for condition in conditions_of(measurements, name):
        lost = [r.force_N for r in condition.readings if not r.valid and np.isfinite(r.force_N)]
        if lost and not condition.used() and condition.position_m is not None:
            axes.plot(
                1e3 * condition.position_m,
                1e3 * float(np.mean(lost)),
                "x",
                color=colour_of(condition.voltage_V, voltages(measurements, name)),
                alpha=0.6,
            )


def _legend(fig: Figure, simulated: bool) -> None:
    from matplotlib.lines import Line2D

    found = {}
    for axes in fig.axes:
        handles, labels = axes.get_legend_handles_labels()
        found.update(dict(zip(labels, handles, strict=True)))
    handles = list(found.values())
    if simulated:
        handles += [
            Line2D([], [], color=INK, linewidth=1.1, linestyle=style, label=kind)
            for kind, style in _LINES.items()
        ]
    if any(line.get_marker() == "x" for axes in fig.axes for line in axes.get_lines()):
        handles.append(Line2D([], [], color=INK, linewidth=0, marker="x", label="invalid"))
    legend_below(fig, handles)
