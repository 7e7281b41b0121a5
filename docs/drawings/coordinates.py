"""Figure 2 of the paper: the coordinates of the sheet, the arc and the contact."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from drawings._sheet import (
    HELP,
    INK,
    RADIUS_MM,
    SHEET,
    angle,
    arc,
    arrow,
    canvas,
    clamp,
    contact,
    rolls,
)


def figure() -> Figure:
    """Return the drawing."""
    found = contact(50.0, 0.0, 22.0, 26.0)
    x, y = found.x_m * 1e3, found.y_m * 1e3
    beta = found.position_m / (RADIUS_MM / 1e3)
    at = RADIUS_MM * np.array([np.cos(beta), np.sin(beta)])
    phi = found.phi_hat_rad
    drawing, (axes,) = canvas(7.2, 4.6)
    clamp(axes)
    arc(axes, -12, 70)
    axes.plot(x, y, color=SHEET, lw=3, solid_capstyle="butt")
    rolls(axes, at, phi)
    arrow(axes, (0, 0), (58, 0), lw=0.9)
    arrow(axes, (0, 0), (0, 31), lw=0.9)
    axes.text(59, 0, "x", va="center")
    axes.text(0, 32, "y", ha="center")
    axes.plot([0, at[0]], [0, at[1]], color=HELP, lw=0.9)
    axes.text(0.62 * at[0] - 1.0, 0.62 * at[1] + 1.4, "R", color=HELP)
    angle(axes, (0, 0), 11, 0, float(np.degrees(beta)), "β = p/R")
    axes.texts[-1].set(ha="left", x=20, y=-3.4)
    half = beta / 2
    axes.text(
        1.06 * RADIUS_MM * np.cos(half), 1.06 * RADIUS_MM * np.sin(half) - 1, "p", fontsize=12
    )
    axes.text(RADIUS_MM + 0.8, -2.8, "position 0", color=HELP)
    tangent, normal = np.array([np.cos(phi), np.sin(phi)]), np.array([-np.sin(phi), np.cos(phi)])
    arrow(axes, at, at + 11 * tangent)
    arrow(axes, at, at + 11 * normal)
    axes.text(*(at + 12.5 * tangent), "t", ha="center", va="center", weight="bold")
    axes.text(*(at + 12.5 * normal), "n", ha="center", va="center", weight="bold")
    axes.plot([at[0], at[0] + 14], [at[1], at[1]], color=HELP, lw=0.8, ls=":")
    angle(axes, at, 8.5, 0, float(np.degrees(phi)), "φ")
    k = int(0.38 * len(x))
    axes.plot(x[k], y[k], "o", color=INK, ms=4)
    axes.annotate(
        "r(s): the point at the\narc length s from the clamp", (x[k], y[k]), (30, 5), color=INK,
        arrowprops={"arrowstyle": "-", "color": HELP, "lw": 0.8},
    )  # fmt: skip
    axes.annotate(
        "contact, s = ŝ", tuple(at), (at[0] - 30, at[1] + 1.0),
        arrowprops={"arrowstyle": "-", "color": HELP, "lw": 0.8},
    )  # fmt: skip
    axes.annotate(
        "free end, s = l",
        (x[-1], y[-1]),
        (x[-1] + 3, y[-1] + 1),
    )
    axes.text(-7, -6.8, "clamp", color=INK)
    axes.set_xlim(-9, 66)
    axes.set_ylim(-9, 45)
    return drawing
