"""Figure 2 of the paper, b and c: the forces at the contact, and the lever of the moment."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drawings._sheet import (
    FORCE,
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
from model import Prediction


def figure() -> Figure:
    """Return the drawing."""
    found = contact(50.0, 0.0, 22.0, 50.0)
    drawing, (left, right) = canvas(8.6, 4.3, panels=2)
    _at_the_contact(left, found)
    _lever(right, found)
    return drawing


def _place(found: Prediction) -> tuple[float, np.ndarray]:
    beta = found.position_m / (RADIUS_MM / 1e3)
    return beta, RADIUS_MM * np.array([np.cos(beta), np.sin(beta)])


def _at_the_contact(axes: Axes, found: Prediction) -> None:
    beta, at = _place(found)
    phi = found.phi_hat_rad
    normal = np.array([-np.sin(phi), np.cos(phi)])
    along = np.array([-np.sin(beta), np.cos(beta)])
    arc(axes, 5, 62)
    near = np.hypot(found.x_m * 1e3 - at[0], found.y_m * 1e3 - at[1]) < 17
    axes.plot(found.x_m[near] * 1e3, found.y_m[near] * 1e3, color=SHEET, lw=3)
    rolls(axes, at, phi)
    arrow(axes, at, at + 15 * normal, FORCE)
    axes.text(*(at + 16.8 * normal), "N n", color=FORCE, ha="center", va="center")
    arrow(axes, at, at - 15 * normal, INK)
    axes.text(*(at - 16.5 * normal + [3, -1.5]), "force on the sheet, −N n", ha="right", va="top")
    size = 15 * np.cos(phi - beta)
    arrow(axes, at, at + size * along, FORCE)
    tip = at + size * along
    axes.text(tip[0] + 1.2, tip[1] + 1.0, "F = N cos γ", color=FORCE, ha="left", va="bottom")
    axes.plot(*zip(at + 15 * normal, tip, strict=True), color=HELP, lw=0.8, ls=":")
    low, high = sorted(np.degrees([np.arctan2(v[1], v[0]) for v in (normal, along)]))
    angle(axes, at, 9.0, low, high, "γ")
    axes.text(at[0] + 7.5, at[1] - 9, "arc", color=HELP)
    axes.set_title("a  The force that is measured, F, lies along the arc", fontsize=10, loc="left")
    axes.set_xlim(at[0] - 20, at[0] + 22)
    axes.set_ylim(at[1] - 21, at[1] + 21)


def _lever(axes: Axes, found: Prediction) -> None:
    _beta, at = _place(found)
    phi = found.phi_hat_rad
    normal, tangent = np.array([-np.sin(phi), np.cos(phi)]), np.array([np.cos(phi), np.sin(phi)])
    clamp(axes)
    arc(axes, -8, 62)
    x, y = found.x_m * 1e3, found.y_m * 1e3
    axes.plot(x, y, color=SHEET, lw=3)
    rolls(axes, at, phi)
    point = np.array([x[int(0.3 * len(x))], y[int(0.3 * len(x))]])
    lever = float((at - point) @ tangent)
    foot = at - lever * tangent
    arrow(axes, at, at - 13 * normal, INK)
    axes.text(*(at - 14.0 * normal), "−N n", ha="left", va="center")
    axes.plot(*zip(at, foot, strict=True), color=HELP, lw=1.0)
    axes.plot(*zip(foot, point, strict=True), color=HELP, lw=0.8, ls=":")
    axes.plot(*point, "o", color=INK, ms=4)
    axes.annotate("r(s)", tuple(point), (point[0] - 1, point[1] + 4), ha="right")
    middle = (at + foot) / 2
    axes.text(middle[0] + 1, middle[1] - 3.2, "lever", color=HELP)
    axes.set_title("b  The moment at s is −N times the lever", fontsize=10, loc="left")
    axes.set_xlim(-9, 56)
    axes.set_ylim(-9, 46)
