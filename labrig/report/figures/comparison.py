"""Measured and simulated neutral curves of one condition (the figure of table 5)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from labrig.report.data.models import ALONG, CONSTANT, Models, predicted
from labrig.report.data.selection import place
from labrig.report.parts.style import (
    ALONG_COLOUR,
    CONSTANT_COLOUR,
    INK,
    figure,
    label_of,
    legend_below,
    letter,
    panels_width_in,
)
from model import Condition, Curve, Measurements, Prediction
from model.measurements import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STYLES = {ALONG: (ALONG_COLOUR, "-"), CONSTANT: (CONSTANT_COLOUR, (0, (4, 2.5)))}
_MARKS = 26  # measured points that are drawn


def comparison_figure(
    measurements: Measurements, chosen: list[Condition], models: Models
) -> Figure:
    """For each condition the bending part's curves above, their distance along it below."""
    with figure(panels_width_in(len(chosen)), 4.6) as fig:
        panels = fig.subplots(2, len(chosen), squeeze=False, height_ratios=[1.7, 1.0])
        for column, mark, condition in zip(panels.T, "abcdefgh", chosen, strict=False):
            _condition(column[0], column[1], measurements, condition, models)
            at = f"{place(condition.position_m)}, {label_of(condition.voltage_V)}"
            letter(column[0], mark, f"{condition.configuration} sheet, {at}")
        panels[0, 0].set_ylabel("y (mm), enlarged")
        panels[1, 0].set_ylabel("distance (mm)")
        legend_below(fig, panels[0, 0].get_legend_handles_labels()[0])
        return fig


def _condition(
    above: Axes, below: Axes, measurements: Measurements, condition: Condition, models: Models
) -> None:
    sheet, curve = measurements.sheets[condition.configuration], condition.curve
    assert curve is not None and condition.position_m is not None  # noqa: S101, PT018 - chosen so
    bends = int(np.count_nonzero(curve.s_m <= sheet.free_length_m + 1e-9))
    thin = np.unique(np.linspace(0, bends - 1, _MARKS).round().astype(int))
    above.plot(
        1e3 * curve.x_m[thin],
        1e3 * curve.y_m[thin],
        "o",
        markersize=3.5,
        markerfacecolor="none",
        markeredgewidth=0.8,
        color=INK,
        label="measured",
    )
    for kind, model in models.named():
        colour, style = _STYLES[kind]
        found = predicted(model, condition.configuration, condition.position_m, condition.voltage_V)
        if found is None:
            continue
        at = found.s_m <= sheet.free_length_m + 1e-9
        x, y = 1e3 * found.x_m[at], 1e3 * found.y_m[at]
        above.plot(x, y, color=colour, linestyle=style, label=f"with {kind}")
        s_m, away_m = distance_m(curve, found, sheet.free_length_m)
        below.plot(1e3 * s_m, 1e3 * away_m, color=colour, linestyle=style)
    above.set_xlabel("x (mm)")
    below.set_xlim(0, 1e3 * sheet.free_length_m)
    below.set_ylim(bottom=0)
    below.set_xlabel("distance along the sheet s (mm)")


def distance_m(curve: Curve, found: Prediction, length_m: float) -> tuple[FloatArray, FloatArray]:
    """S of the bending part's measured points, and how far each is from the simulated curve."""
    bends = curve.s_m <= length_m + 1e-9
    points = np.column_stack([curve.x_m, curve.y_m])[bends]
    line = np.column_stack([found.x_m, found.y_m])
    start, along = line[:-1], np.diff(line, axis=0)
    to = points[:, None, :] - start
    share = np.clip(np.sum(to * along, axis=2) / np.sum(along**2, axis=1), 0.0, 1.0)
    away = np.linalg.norm(to - share[:, :, None] * along, axis=2)
    return curve.s_m[bends], np.min(away, axis=1)
