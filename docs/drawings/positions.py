"""Figure 4 of the paper: the positions on the arc at which force and shape are measured."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from drawings._sheet import HELP, INK, RADIUS_MM, SHEET, arc, arrow, canvas, clamp, contact


def figure() -> Figure:
    """Return the drawing."""
    drawing, (axes,) = canvas(6.4, 4.2)
    clamp(axes)
    arc(axes, -10, 62)
    found = contact(50.0, 0.0, 15.0, 9.6)
    axes.plot(found.x_m * 1e3, found.y_m * 1e3, color=SHEET, lw=3)
    for position_mm in range(0, 31, 5):
        beta = position_mm / RADIUS_MM
        out = np.array([np.cos(beta), np.sin(beta)])
        axes.plot(*(RADIUS_MM * out), "o", color=INK, ms=5)
        axes.text(
            *((RADIUS_MM + 4.0) * out),
            f"{position_mm}",
            ha="center",
            va="center",
            bbox={"fc": "w", "ec": "none", "pad": 0.6},
        )
    last = 30 / RADIUS_MM
    axes.text(
        (RADIUS_MM + 7.5) * np.cos(last), (RADIUS_MM + 7.5) * np.sin(last), "mm along the arc",
        color=HELP,
    )  # fmt: skip
    axes.plot([0, RADIUS_MM], [0, 0], color=HELP, lw=0.8)
    arrow(axes, (0, 0), RADIUS_MM * np.array([np.cos(-0.12), np.sin(-0.12)]), HELP, lw=0.9)
    axes.text(17, -6.2, "R = 40 mm", color=HELP)
    axes.set_xlim(-9, 66)
    axes.set_ylim(-9, 37)
    return drawing
