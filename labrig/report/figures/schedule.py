"""The figure of a schedule: voltage over time, and the times of the readings (figure 5)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from labrig.report.parts.style import colour_of, figure, save
from protocols import PlannedRun, ReadingKind, Schedule, timeline

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MARKS = {
    ReadingKind.ZERO: ("o", "reading"),
    ReadingKind.KEPT: ("o", "reading"),
    ReadingKind.DISCARDED: ("x", "discarded"),
    ReadingKind.NO_CONTACT: ("s", "no contact"),
}


def draw_schedule(schedule: Schedule, path: Path) -> None:
    """Draw the first run of each kind of run in the schedule, one panel each."""
    runs = list({run.in_words: run for run in reversed(schedule.runs)}.values())[::-1]
    with figure(9.0, 2.2 * len(runs) + 0.4) as fig:
        panels = fig.subplots(len(runs), 1, squeeze=False)[:, 0]
        for axes, run in zip(panels, runs, strict=True):
            draw_run(axes, run)
        save(fig, path)


def draw_run(axes: Axes, run: PlannedRun) -> None:
    """Draw one run's voltage and its sampling points on `axes`."""
    line = timeline(run)
    axes.plot(line.time_s, line.voltage_V, color="#888888", linewidth=1.2)
    labelled: set[str] = set()
    for reading in run.readings:
        marker, label = _MARKS[reading.kind]
        axes.plot(
            run.time_of(reading),
            reading.voltage_V,
            marker,
            color=colour_of(reading.voltage_V),
            markersize=4,
            label=None if label in labelled else label,
        )
        labelled.add(label)
    axes.set_title(f"{run.in_words}, {run.configuration}", loc="left")
    axes.set_xlabel("time (s)")
    axes.set_ylabel("sheet voltage (V)")
    if labelled:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.0)
