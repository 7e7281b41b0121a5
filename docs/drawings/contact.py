"""Where the rolls touch: on the sheet itself, or on its rigid elongation."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from drawings._sheet import INK, RADIUS_MM, SHEET, arc, canvas, clamp, contact, rolls


def figure() -> Figure:
    """Return the drawing."""
    drawing, panels = canvas(8.6, 3.9, panels=2)
    cases = (
        ("a  Contact on the sheet, ŝ < l", contact(50.0, 0.0, 14.0, 30.0), 50.0),
        ("b  Contact on the elongation, ŝ > l", contact(4.5, 40.0, 14.0, 100.0), 4.5),
    )
    for axes, (title, found, length_mm) in zip(panels, cases, strict=True):
        clamp(axes)
        arc(axes, -12, 50)
        x, y, s = found.x_m * 1e3, found.y_m * 1e3, found.s_m * 1e3
        bends = s <= length_mm + 1e-6
        axes.plot(x[~bends], y[~bends], color=INK, lw=2)
        axes.plot(x[bends], y[bends], color=SHEET, lw=3.2)
        beta = found.position_m * 1e3 / RADIUS_MM
        rolls(axes, RADIUS_MM * np.array([np.cos(beta), np.sin(beta)]), found.phi_hat_rad)
        axes.set_title(title, fontsize=10, loc="left")
        axes.set_xlim(-9, 58)
        axes.set_ylim(-11, 33)
    end = panels[0].lines[-1]
    panels[0].annotate(
        "beyond the contact the sheet\nis free: no force bends it",
        (end.get_xdata()[-4], end.get_ydata()[-4]), (6, 25),
        arrowprops={"arrowstyle": "-", "color": INK, "lw": 0.7},
    )  # fmt: skip
    panels[1].text(-5, 12, "only these 4.5 mm bend", color=SHEET)
    panels[1].annotate(
        "", (2.5, 1.0), (8, 11.3), arrowprops={"arrowstyle": "-", "color": SHEET, "lw": 0.8}
    )
    panels[1].text(16, 25, "rigid elongation: straight", color=INK)
    panels[1].annotate(
        "", (25, 9.5), (26, 24.3), arrowprops={"arrowstyle": "-", "color": INK, "lw": 0.7}
    )
    return drawing
