"""The electrically induced bending moment along the sheet (figure 8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from labrig.report.data.models import CONSTANT, Models
from labrig.report.parts.style import (
    INK,
    colour_of,
    figure,
    label_of,
    legend_below,
    letter,
    panels_width_in,
)
from model import Along, SheetModel

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_REACH = 1.645  # standard uncertainties to either side: 90 %


def moment_figure(models: Models, names: list[str]) -> Figure:
    """Figure 8: the EIBM along the sheet with its 90 % band, and the constant EIBM."""
    with figure(panels_width_in(len(names)), 3.3) as fig:
        panels = fig.subplots(1, len(names), squeeze=False)[0]
        for axes, name, mark in zip(panels, names, "abcdefgh", strict=False):
            draw_moments(axes, models.along, name, models.constant)
            letter(axes, mark, f"{name} sheet")
        panels[0].set_ylabel("EIBM (µN·m)")
        _legend(fig)
        return fig


def draw_moments(
    axes: Axes, model: SheetModel, name: str, constant: SheetModel | None = None
) -> None:
    """Draw the EIBMs of a configuration along the sheet, and those of the constant model."""
    one = model.sheet(name)
    axes.axhline(0, color=INK, linewidth=0.7, alpha=0.6)
    for volts in sorted(one.eibm, reverse=True):
        colour = colour_of(volts, one.eibm)
        _band(axes, one.eibm[volts], one.sheet.free_length_m, volts, colour)
        for mean in [] if constant is None else _constant(constant, name, volts):
            axes.axhline(1e6 * mean, color=colour, linewidth=1.0, linestyle=(0, (5, 3)))
    axes.set_xlabel("distance along the sheet s (mm)")
    axes.set_xlim(0, 1e3 * one.sheet.free_length_m)


def _band(axes: Axes, along: Along, length_m: float, volts: float, colour: str) -> None:
    # beyond the outer nodes it is constant, as the model takes it; one node: everywhere
    at = np.unique(np.concatenate([[0.0, length_m], along.s_m]))
    s, Me = 1e3 * at, 1e6 * np.interp(at, along.s_m, along.values)
    reach = 1e6 * _REACH * np.interp(at, along.s_m, along.sigma)
    axes.plot(s, Me, color=colour, label=label_of(volts))
    axes.fill_between(s, Me - reach, Me + reach, color=colour, alpha=0.2, linewidth=0)


def _constant(model: SheetModel, name: str, volts: float) -> list[float]:
    """Return the mean of the constant model's EIBM, where it has one."""
    sheet = model.sheets.get(name)
    return [] if sheet is None or volts not in sheet.eibm else [sheet.mean_eibm(volts)]


def _legend(fig: Figure) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    lines = {
        str(line.get_label()): line
        for axes in fig.axes
        for line in axes.get_lines()
        if not str(line.get_label()).startswith("_")
    }
    known: list[Artist] = [
        *lines.values(),
        Patch(color=INK, alpha=0.2, linewidth=0, label="90 % interval"),
        Line2D([], [], color=INK, linewidth=1.0, linestyle=(0, (5, 3)), label=CONSTANT),
    ]
    legend_below(fig, known)
