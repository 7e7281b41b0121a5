"""Figure 3 of the paper: what the rig is made of, and how it is wired."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from drawings._sheet import FORCE, HELP, INK, SHEET, arrow, canvas


def figure() -> Figure:
    """Return the drawing."""
    drawing, (axes,) = canvas(8.6, 3.9)
    _box(axes, 0, 14, 17, 16, "computer\nlabrig")
    _box(axes, 28, 34, 21, 9, "output board\nPCI-6703")
    _box(axes, 28, 16, 21, 12, "input board\nPCI-6034E")
    _box(axes, 28, 0, 21, 9, "camera\n25 frames/s")
    _box(axes, 61, 34, 21, 9, "amplifier\nLM675")
    _box(axes, 61, 0, 21, 9, "load cell\nGSO-10", FORCE)
    _box(axes, 94, 16, 18, 12, "clamp and\nsheet", SHEET)
    arrow(axes, (17, 27), (28, 38))
    arrow(axes, (28, 22), (17, 22))
    arrow(axes, (28, 5), (17, 17))
    arrow(axes, (49, 38.5), (61, 38.5))
    arrow(axes, (82, 38.5), (100, 28))
    axes.text(93, 36, "voltage", color=INK)
    arrow(axes, (71.5, 34), (49, 26))
    axes.text(63, 29.3, "voltage, read back", color=INK)
    arrow(axes, (94, 22), (49, 22))
    axes.text(63, 22.8, "current, over a shunt", color=INK)
    arrow(axes, (66, 9), (49, 18))
    axes.text(60, 13.4, "force", color=FORCE)
    arrow(axes, (100, 16), (82, 5), FORCE)
    axes.text(93, 7, "two rolls on the arc", color=FORCE)
    axes.plot([107, 107, 38.5], [16, -4, -4], color=HELP, ls="--", lw=1.2)
    arrow(axes, (38.5, -4), (38.5, -0.4), HELP)
    axes.text(62, -3.2, "sees the sheet from above", color=HELP)
    axes.set_xlim(-1, 120)
    axes.set_ylim(-5.5, 46)
    return drawing


def _box(
    axes: Axes, left: float, bottom: float, width: float, height: float, text: str, ink: str = INK
) -> None:
    shape = FancyBboxPatch(
        (left, bottom), width, height, boxstyle="round,pad=0.2,rounding_size=1.2", fc="w", ec=ink
    )
    axes.add_patch(shape)
    axes.text(left + width / 2, bottom + height / 2, text, ha="center", va="center", color=ink)
