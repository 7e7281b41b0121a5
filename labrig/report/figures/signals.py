"""Over time: the input voltage with its readings (figure 5), and the sheet's current (figure 6)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from labrig.report.data.selection import place
from labrig.report.parts.style import INK, colour_of, figure, letter
from model import Measurements, Reading, TimeSeries

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_KINDS = {
    "zero": ("o", "reading"),
    "kept": ("o", "reading"),
    "discarded": ("x", "discarded"),
    "no_contact": ("s", "no contact"),
}
_CLOSE_UP = 2.3  # pulses
_DRIVEN_V = 0.1  # more than the amplifier's offset


def series_of(measurements: Measurements, configuration: str) -> TimeSeries | None:
    """Return the first recorded run of a configuration in which the sheet was driven."""
    for series in measurements.series:
        driven = len(series.time_s) > 1 and np.nanmax(np.abs(series.drive_V)) > _DRIVEN_V
        if series.configuration == configuration and driven and not series.extra:
            return series
    return None


def readings_of(measurements: Measurements, series: TimeSeries) -> list[tuple[float, Reading]]:
    """Return the voltage and the reading of all readings of a run, in time order."""
    found = [
        (condition.voltage_V, reading)
        for condition in measurements.conditions
        if (condition.configuration, condition.position_m, condition.mounting, condition.run)
        == (series.configuration, series.position_m, series.mounting, 0)
        for reading in condition.readings
        if reading.time_s is not None
    ]
    return sorted(found, key=lambda pair: pair[1].index)


def voltage_figure(
    measurements: Measurements, series: TimeSeries, half_window_s: float = 0.0
) -> Figure:
    """Figure 5: the sheet's voltage as read back, and the sampling points; a close-up below.

    `half_window_s`: how far a reading's filter reaches to either side of its sampling point.
    """
    readings = readings_of(measurements, series)
    with figure(7.2, 4.6) as fig:
        whole, close = fig.subplots(2, 1, height_ratios=[1.0, 1.0])
        for axes in (whole, close):
            axes.plot(series.time_s, series.drive_V, color=INK, linewidth=0.9, label="voltage")
            _mark(axes, readings)
            axes.set_ylabel("sheet voltage (V)")
        for _, reading in readings:
            if reading.time_s is not None and half_window_s > 0:
                reach = (reading.time_s - half_window_s, reading.time_s + half_window_s)
                close.axvspan(*reach, color=INK, alpha=0.08, linewidth=0)
        letter(whole, "a", f"{series.configuration} sheet, {place(series.position_m)}")
        letter(close, "b", "the same, close up")
        whole.set_xlim(*_whole(series))
        close.set_xlim(*_first_pulses(series, readings))
        close.set_xlabel("time (s)")
        high = 1.25 * float(np.nanmax(np.abs(series.drive_V)))
        whole.set_ylim(-high, 1.35 * high)
        close.set_ylim(-high, high)
        whole.legend(loc="upper left", ncols=4, handlelength=1.4)
        return fig


def current_figure(series: TimeSeries, readings: list[tuple[float, Reading]]) -> Figure:
    """Figure 6: the sheet's current; `series` must hold one."""
    assert series.current_A is not None  # noqa: S101 - asked for before
    current_mA = 1e3 * series.current_A
    with figure(7.2, 4.6) as fig:
        whole, close = fig.subplots(2, 1)
        for axes in (whole, close):
            axes.plot(series.time_s, current_mA, color=INK, linewidth=0.9)
            axes.axhline(0, color=INK, linewidth=0.6, alpha=0.5)
            axes.set_ylabel("current (mA)")
        letter(whole, "a", f"{series.configuration} sheet, {place(series.position_m)}")
        letter(close, "b", "the same, close up")
        whole.set_xlim(*_whole(series))
        close.set_xlim(*_first_pulses(series, readings))
        close.set_xlabel("time (s)")
        return fig


def _whole(series: TimeSeries) -> tuple[float, float]:
    return float(series.time_s[0]), float(series.time_s[-1])


def _first_pulses(series: TimeSeries, readings: list[tuple[float, Reading]]) -> tuple[float, float]:
    """From shortly before the first pulse until a few pulses later."""
    driven = np.flatnonzero(np.abs(series.drive_V) > 0.5 * np.nanmax(np.abs(series.drive_V)))
    start = float(series.time_s[driven[0]]) if len(driven) else float(series.time_s[0])
    times = [r.time_s for volts, r in readings if volts != 0 and r.time_s is not None]
    pulse = float(np.median(np.diff(times))) if len(times) > 1 else 1.0
    return start - 0.5 * pulse, start + _CLOSE_UP * pulse


def _mark(axes: Axes, readings: list[tuple[float, Reading]]) -> None:
    labelled: set[str] = set()
    for volts, reading in readings:
        marker, label = _KINDS[reading.kind] if reading.valid else ("D", "invalid")
        axes.plot(
            [float("nan") if reading.time_s is None else reading.time_s],
            [volts],
            marker,
            color=colour_of(volts),
            markerfacecolor="none" if not reading.valid else None,
            markersize=4.5,
            label=None if label in labelled else label,
            zorder=3,
        )
        labelled.add(label)
