"""The electrically induced bending moment along the sheet (figure 8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
            _moments(axes, models, name)
            letter(axes, mark, f"{name} sheet")
        panels[0].set_ylabel("EIBM (µN·m)")
        _legend(fig)
        return fig


def _moments(axes: Axes, models: Models, name: str) -> None:
    axes.axhline(0, color=INK, linewidth=0.7, alpha=0.6)
    for volts in sorted(models.along.sheets[name].eibm, reverse=True):
        colour = colour_of(volts)
        _band(axes, models.along.sheets[name].eibm[volts], colour, volts)
        for mean in _constant(models.constant, name, volts):
            axes.axhline(1e6 * mean, color=colour, linewidth=1.0, linestyle=(0, (5, 3)))
    axes.set_xlabel("distance along the sheet s (mm)")
    axes.set_xlim(0, 1e3 * models.along.sheets[name].sheet.free_length_m)


def _band(axes: Axes, along: Along, colour: str, volts: float) -> None:
    s, Me, reach = 1e3 * along.s_m, 1e6 * along.values, 1e6 * _REACH * along.sigma
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
