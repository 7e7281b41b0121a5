"""An image of the sheet with the neutral curve that was found in it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.report.data.selection import place
from labrig.report.parts.style import figure, label_of, letter
from labrig.session import RecordedSession
from labrig.vision import Optics
from model import Condition
from model.measurements import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FOUND = "#56B4E9"  # light, to be seen on the image
_MARGIN_PX = 30


def mean_image(session: RecordedSession, condition: Condition) -> FloatArray | None:
    """Return the mean of a condition's frames as light intensities, as the paper has it."""
    used = {reading.index for reading in condition.used()}
    images = [
        frame.astype(float)
        for run in session.runs
        if run.started
        and (run.planned.configuration, run.planned.position_m, run.planned.mounting)
        == (condition.configuration, condition.position_m, condition.mounting)
        for row in run.readings
        if row["index"] in used and row["voltage_V"] == condition.voltage_V
        if (frame := run.frame(int(row["index"]))) is not None
    ]
    return np.mean(images, axis=0) if images else None


def frame_figure(
    session: RecordedSession, optics: Optics, chosen: list[Condition]
) -> Figure | None:
    """Figure of the mean images of conditions with their curves; None without any image."""
    images = [(condition, mean_image(session, condition)) for condition in chosen]
    seen = [(c, image) for c, image in images if image is not None and c.curve is not None]
    if not seen:
        return None
    with figure(4.0 * len(seen), 3.4) as fig:
        panels = fig.subplots(1, len(seen), squeeze=False)[0]
        for axes, (condition, image), mark in zip(panels, seen, "abcdefgh", strict=False):
            _panel(axes, image, _pixels(optics, condition))
            at = f"{place(condition.position_m)}, {label_of(condition.voltage_V)}"
            letter(axes, mark, f"{condition.configuration} sheet, {at}")
        return fig


def _pixels(optics: Optics, condition: Condition) -> FloatArray:
    assert condition.curve is not None  # noqa: S101 - chosen so
    return optics.world_to_pixel(np.column_stack([condition.curve.x_m, condition.curve.y_m]))


def _panel(axes: Axes, image: FloatArray, pixels: FloatArray) -> None:
    low, high = np.percentile(image, [1.0, 99.9])
    axes.imshow(image, cmap="gray", vmin=low, vmax=max(high, low + 1.0), interpolation="nearest")
    axes.plot(pixels[:, 0], pixels[:, 1], color=_FOUND, linewidth=0.9)
    rows, columns = image.shape
    axes.set_xlim(*_window(pixels[:, 0], columns))
    bottom, top = _window(pixels[:, 1], rows)
    axes.set_ylim(top, bottom)
    axes.grid(visible=False)
    axes.set_xlabel("column (pixels)")
    axes.set_ylabel("row (pixels)")
    _magnified(axes, image, pixels, (low, high))


def _window(values: FloatArray, size: int) -> tuple[float, float]:
    """Return the part of an axis that holds the curve with a margin, at least half of it."""
    low, high = float(values.min()) - _MARGIN_PX, float(values.max()) + _MARGIN_PX
    short = max(0.0, 0.5 * size - (high - low)) / 2
    low, high = low - short, high + short
    shift = max(0.0, -low) - max(0.0, high - (size - 1))
    return max(low + shift, -0.5), min(high + shift, size - 0.5)


def _magnified(axes: Axes, image: FloatArray, pixels: FloatArray, grey: Any) -> None:
    """Enlarge a few pixels around the middle of the curve."""
    u, v = pixels[len(pixels) // 3]
    inset = axes.inset_axes((0.03, 0.6, 0.36, 0.36))
    inset.imshow(image, cmap="gray", vmin=grey[0], vmax=grey[1], interpolation="nearest")
    inset.plot(pixels[:, 0], pixels[:, 1], color=_FOUND, linewidth=1.0)
    inset.set_xlim(u - 10, u + 10)
    inset.set_ylim(v + 8, v - 8)
    inset.set(xticks=[], yticks=[])
    inset.grid(visible=False)
    for side in inset.spines.values():
        side.set(visible=True, color=_FOUND, linewidth=0.8)
    axes.indicate_inset_zoom(inset, edgecolor=_FOUND, alpha=0.9)
