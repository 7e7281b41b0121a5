"""Force, current and tip over a pulse: measured, and simulated with a model in time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from labrig.report.parts.style import (
    INK,
    NEGATIVE,
    POSITIVE,
    figure,
    legend_below,
    letter,
    panels_width_in,
)
from model.dynamics import DynamicBeam, SheetMotion, simulate
from model.dynamics.identification import RecordedRun
from model.measurements import FloatArray

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_EVERY_S, _EDGE_S = 1e-3, 2e-3
_BEFORE_S, _AFTER_S = 0.1, 0.3  # of a pulse that are drawn, too


@dataclass(frozen=True, kw_only=True)
class ComparedRun:
    """A recorded run, and what a model says of it at each ms and at each sample and frame."""

    recorded: RecordedRun
    simulated: SheetMotion

    @property
    def force_rms_N(self) -> float:
        """Of measured less simulated force, of single samples; NaN where none was measured."""
        return self._rms(self.recorded.force_N, self.simulated.reading_N)

    @property
    def current_rms_A(self) -> float:
        """Of the current. Samples at edges of the voltage are left out, where it jumps."""
        return self._rms(self.recorded.current_A, self.simulated.current_A)

    @property
    def tip_rms_m(self) -> float:
        """Of the distance between the last point seen of the sheet and the same one simulated."""
        if self.recorded.x_m is None or self.recorded.y_m is None:
            return np.nan
        x, y = self.tip_at(self.recorded.plan.frame_s)
        gap = np.hypot(self.recorded.x_m[:, -1] - x, self.recorded.y_m[:, -1] - y)
        return float(np.sqrt(np.nanmean(gap**2)))

    def tip_at(self, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return x and y of the last point at some times."""
        motion = self.simulated
        x, y = (np.interp(time_s, motion.time_s, one[:, -1]) for one in (motion.x_m, motion.y_m))
        return np.asarray(x), np.asarray(y)

    def pulse_s(self) -> tuple[float, float]:
        """Return begin and end of the first pulse."""
        drive = self.recorded.plan.drive
        size = np.abs(drive.voltage_V)
        (large,) = np.nonzero((size > 0.5 * size.max()) & (drive.time_s >= 0.0))
        first = int(large[0])
        end = drive.time_s[first + 1] if first + 1 < len(drive.time_s) else self._end_s
        return float(drive.time_s[first]), float(end)

    @property
    def _end_s(self) -> float:
        return float(self.simulated.time_s[-1])

    def _rms(self, measured: FloatArray | None, simulated: FloatArray) -> float:
        if measured is None:
            return np.nan
        times, edges = self.recorded.plan.time_s, self.recorded.plan.drive.time_s
        away = np.min(np.abs(times[:, None] - edges), axis=1) > _EDGE_S
        at = np.interp(times, self.simulated.time_s, simulated)
        return float(np.sqrt(np.mean((measured - at)[away] ** 2)))


def compared(beam: DynamicBeam, recorded: RecordedRun) -> ComparedRun:
    """Return a recorded run with what a model says of it. Raises ModelError."""
    plan = recorded.plan
    end_s = max(float(times[-1]) for times in (plan.time_s, plan.frame_s) if len(times))
    even = np.arange(0.0, end_s, _EVERY_S)
    times = np.unique(np.concatenate([even, plan.time_s, plan.frame_s]).round(9))
    points = plan.points_m[-1:] if len(plan.points_m) else np.array([beam.length_m])
    return ComparedRun(
        recorded=recorded, simulated=simulate(beam, plan.setup, plan.drive, times, s_m=points)
    )


def motion_figure(held: ComparedRun, free: ComparedRun) -> Figure:
    """Force and current over a pulse in contact, the tip over a pulse of the free sheet."""
    with figure(panels_width_in(3), 3.2) as fig:
        panels = fig.subplots(1, 3)
        _signal(panels[0], held, held.recorded.force_N, held.simulated.reading_N)
        panels[0].set_ylabel("force F (mN)")
        _signal(panels[1], held, held.recorded.current_A, held.simulated.current_A)
        panels[1].set_ylabel("current (mA)")
        _tip(panels[2], free)
        for axes, mark, title in zip(
            panels, "abc", ("force on the rolls", "current", "free tip"), strict=True
        ):
            letter(axes, mark, title)
            axes.set_xlabel("time since the voltage (s)")
        legend_below(fig, _legend())
        return fig


def _signal(
    axes: Axes, run: ComparedRun, measured: FloatArray | None, simulated: FloatArray
) -> None:
    begin_s, end_s = run.pulse_s()
    if measured is not None:
        _within(axes, run.recorded.plan.time_s, measured, begin_s, end_s, ".", INK)
    _within(axes, run.simulated.time_s, simulated, begin_s, end_s, "-", POSITIVE)


def _tip(axes: Axes, run: ComparedRun) -> None:
    begin_s, _ = run.pulse_s()
    end_s = float(run.simulated.time_s[-1])
    times, frames = run.simulated.time_s, run.recorded.plan.frame_s
    seen = run.recorded.x_m, run.recorded.y_m
    for measured, simulated, colour in zip(
        seen, run.tip_at(times), (NEGATIVE, POSITIVE), strict=True
    ):
        if measured is not None:
            _within(axes, frames, measured[:, -1], begin_s, end_s, "o", INK)
        _within(axes, times, simulated, begin_s, end_s, "-", colour)
    axes.set_ylabel("place (mm)")


def _within(
    axes: Axes,
    times: FloatArray,
    values: FloatArray,
    begin_s: float,
    end_s: float,
    mark: str,
    colour: str,
) -> None:
    """Draw what lies about a pulse, in thousandths; time counts from its begin."""
    show = (times >= begin_s - _BEFORE_S) & (times <= end_s + _AFTER_S)
    size = {".": 1.5, "o": 2.6}.get(mark)
    look = {"color": colour, "markersize": size, "linestyle": "none", "marker": mark}
    if size is None:
        look = {"color": colour, "linestyle": mark}
    axes.plot(times[show] - begin_s, 1e3 * values[show], **look)


def _legend() -> list[Artist]:
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=INK, marker=".", linestyle="none", label="measured"),
        Line2D([], [], color=POSITIVE, label="simulated (tip: y)"),
        Line2D([], [], color=NEGATIVE, label="simulated, tip: x"),
    ]
