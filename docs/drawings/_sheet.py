"""A sheet in contact, as the model computes it, and how drawings look."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Rectangle

from model import Along, ConfiguredSheet, Parameter, Prediction, SheetGeometry, SheetModel, predict

INK, SHEET, FORCE, HELP = "#1b1f24", "#0072B2", "#D55E00", "#767676"
RADIUS_MM = 40.0


def contact(
    length_mm: float, elongation_mm: float, position_mm: float, moment: float
) -> Prediction:
    """Return the shape of a sheet with constant EIBM (moment over stiffness, 1/m) in contact."""
    stiffness = 1.27e-6
    geometry = SheetGeometry(
        configuration="sheet",
        free_length_m=length_mm / 1e3,
        width_m=0.011,
        thickness_m=0.21e-3,
        elongation_m=elongation_mm / 1e3,
        arc_radius_m=RADIUS_MM / 1e3,
        arc_origin_rad=0.0,
        initial_curvature=None,
    )
    sheet = ConfiguredSheet(
        sheet=geometry,
        B=_exact(stiffness, "N m^2"),
        rest=Along.constant(_exact(0.0, "1/m")),
        eibm={1.0: Along.constant(_exact(stiffness * moment, "N m"))},
    )
    return predict(SheetModel(sheets={"sheet": sheet}), "sheet", position_mm / 1e3, 1.0)


def _exact(value: float, unit: str) -> Parameter:
    return Parameter(value=value, sigma=0.0, unit=unit)


def canvas(width: float, height: float, panels: int = 1) -> tuple[Figure, list[Axes]]:
    """Return a figure without axes lines, its panels side by side."""
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = [figure.add_subplot(1, panels, k + 1) for k in range(panels)]
    for one in axes:
        one.set_aspect("equal")
        one.axis("off")
    return figure, axes


def clamp(axes: Axes) -> None:
    """Draw the clamp left of the origin."""
    for bottom in (0.7, -3.7):
        axes.add_patch(Rectangle((-7.0, bottom), 7.0, 3.0, fc="#d8dce2", ec=INK, lw=0.8))
    axes.plot([-7.0, 0.0], [0.0, 0.0], color=SHEET, lw=3)


def arc(axes: Axes, low_deg: float, high_deg: float) -> None:
    """Draw the arc on which the load cell sits."""
    size = 2 * RADIUS_MM
    axes.add_patch(
        Arc((0, 0), size, size, theta1=low_deg, theta2=high_deg, color=HELP, ls="--", lw=1)
    )


def rolls(axes: Axes, at: Sequence[float], angle_rad: float) -> None:
    """Draw the two rolls of the load cell beside the sheet."""
    normal = np.array([-np.sin(angle_rad), np.cos(angle_rad)])
    for side in (-1.75, 1.75):
        centre = np.asarray(at) + side * normal
        axes.add_patch(Circle((float(centre[0]), float(centre[1])), 1.3, fc="w", ec=INK, lw=0.9))


def arrow(
    axes: Axes, tail: Sequence[float], head: Sequence[float], colour: str = INK, **more: Any
) -> None:
    """Draw an arrow."""
    style = {"arrowstyle": "-|>", "color": colour, "lw": 1.4, "shrinkA": 0, "shrinkB": 0} | more
    axes.annotate("", xy=tuple(head), xytext=tuple(tail), arrowprops=style)


def angle(
    axes: Axes, at: Sequence[float], size: float, low_deg: float, high_deg: float, label: str
) -> None:
    """Draw an angle with its name beside the middle."""
    axes.add_patch(Arc(tuple(at), 2 * size, 2 * size, theta1=low_deg, theta2=high_deg, color=INK))
    middle = np.radians((low_deg + high_deg) / 2)
    axes.text(
        at[0] + 1.25 * size * np.cos(middle), at[1] + 1.25 * size * np.sin(middle), label,
        ha="center", va="center",
    )  # fmt: skip
