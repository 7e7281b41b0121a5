"""Neutral curves: as measured (figure 7), and compared with the simulated ones (table 5)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.report.data.selection import conditions_of, positions_m, voltages
from labrig.report.parts.style import (
    INK,
    colour_of,
    figure,
    label_of,
    legend_below,
    letter,
    panels_width_in,
)
from model import Curve, Measurements, SheetGeometry
from model.measurements import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HIGHEST_IN = 4.6  # of figure 7
_BESIDE_IN = 0.6  # a panel's numbers and label
_ABOVE_AND_BELOW_IN = 1.2  # title, numbers, label, legend
_MOSTLY_RIGID = 3.0  # elongation over free length, from which on the bending part gets an inset


def curves_figure(measurements: Measurements, names: list[str]) -> Figure:
    """Figure 7: all curves of each configuration, the arc and the clamp; equal aspect."""
    width_in = panels_width_in(len(names))
    with figure(width_in, _HIGHEST_IN) as fig:
        panels = fig.subplots(1, len(names), squeeze=False)[0]
        for axes, name, mark in zip(panels, names, "abcdefgh", strict=False):
            draw_curves(axes, measurements, name)
            letter(axes, mark, f"{name} sheet")
        handles = {h.get_label(): h for axes in panels for h in axes.get_lines() if _shown(h)}
        legend_below(fig, list(handles.values()))
        steepest = max(np.ptp(axes.get_ylim()) / np.ptp(axes.get_xlim()) for axes in panels)
        panel_in = width_in / len(names) - _BESIDE_IN
        fig.set_figheight(min(_HIGHEST_IN, float(steepest) * panel_in + _ABOVE_AND_BELOW_IN))
        return fig


def _shown(line: Any) -> bool:
    return not str(line.get_label()).startswith("_")


def draw_curves(axes: Axes, measurements: Measurements, name: str) -> None:
    """Draw all measured curves of a configuration, the arc and the clamp; equal aspect."""
    sheet = measurements.sheets[name]
    draw_setup(axes, sheet, positions_m(measurements, name))
    _draw_conditions(axes, measurements, name)
    _label_positions(axes, measurements, name)
    if sheet.elongation_m > _MOSTLY_RIGID * sheet.free_length_m:
        _magnify_free_part(axes, measurements, name)


def _draw_conditions(
    axes: Axes, measurements: Measurements, name: str, weight: float = 1.0
) -> None:
    among = voltages(measurements, name)
    for volts in among:
        label: str | None = label_of(volts)
        for condition in conditions_of(measurements, name):
            if condition.voltage_V == volts and condition.curve is not None:
                sheet = measurements.sheets[name]
                draw_curve(
                    axes,
                    condition.curve,
                    sheet,
                    colour=colour_of(volts, among),
                    label=label,
                    weight=weight,
                )
                label = None


def _label_positions(axes: Axes, measurements: Measurements, name: str) -> None:
    """Label the position of each bundle of curves, beyond their ends."""
    for position in positions_m(measurements, name):
        ends = [
            1e3 * np.array([c.curve.x_m[-1], c.curve.y_m[-1]])
            for c in conditions_of(measurements, name)
            if c.position_m == position and c.curve is not None
        ]
        if ends:
            middle = np.mean(ends, axis=0)
            away = max(float(np.hypot(*end)) for end in ends) + 1.8
            x, y = middle / np.hypot(*middle) * away
            axes.text(x, y, f"{1e3 * position:g}", fontsize=7.5, ha="center", va="center")
    axes.margins(0.07)


def _magnify_free_part(axes: Axes, measurements: Measurements, name: str) -> None:
    """Add an inset where the sheet is much shorter than its elongation."""
    reach = 1e3 * measurements.sheets[name].free_length_m
    inset = axes.inset_axes((0.03, 0.55, 0.44, 0.4))
    _draw_conditions(inset, measurements, name, weight=0.6)
    inset.set_xlim(-0.05 * reach, 1.25 * reach)
    inset.set_ylim(-0.25 * reach, 1.0 * reach)
    inset.set_aspect("equal")
    inset.tick_params(labelsize=7)
    inset.text(0.05, 0.88, "free part", fontsize=7.5, transform=inset.transAxes)


def draw_curve(
    axes: Axes,
    curve: Curve,
    sheet: SheetGeometry,
    *,
    colour: str,
    label: str | None = None,
    weight: float = 1.0,
) -> None:
    """Draw a curve in mm; the rigid elongation as a thinner line than the sheet."""
    bends = curve.s_m <= sheet.free_length_m + 1e-9
    x, y = 1e3 * curve.x_m, 1e3 * curve.y_m
    axes.plot(x[bends], y[bends], color=colour, linewidth=1.3 * weight, label=label)
    if not bends.all():
        rest = slice(max(int(bends.sum()) - 1, 0), None)
        axes.plot(x[rest], y[rest], color=colour, linewidth=0.6 * weight)


def draw_setup(axes: Axes, sheet: SheetGeometry, positions: list[float]) -> None:
    """Draw the clamp, the arc and the load cell's positions on it, in mm."""
    from matplotlib.patches import Rectangle

    radius = 1e3 * sheet.arc_radius_m
    tall = 0.06 * radius
    clamp = Rectangle((-2 * tall, -tall), 2 * tall, 2 * tall, color=INK, alpha=0.35, linewidth=0)
    axes.add_patch(clamp)
    if positions:
        beta = np.array(positions) / sheet.arc_radius_m + sheet.arc_origin_rad
        margin = 0.12
        arc = np.linspace(beta.min() - margin, beta.max() + margin, 100)
        axes.plot(radius * np.cos(arc), radius * np.sin(arc), color=INK, linewidth=0.7, alpha=0.6)
        _ticks(axes, radius, beta)
    axes.set_aspect("equal")
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")


def _ticks(axes: Axes, radius: float, beta: FloatArray) -> None:
    for angle in beta:
        way = np.array([np.cos(angle), np.sin(angle)])
        ends = np.outer([radius - 0.7, radius + 0.7], way)
        axes.plot(ends[:, 0], ends[:, 1], color=INK, linewidth=0.9)
