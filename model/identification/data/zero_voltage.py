"""The voltage that reaches the sheet while none is asked for, such as an amplifier's offset.

An offset of 10 mV bends a sheet as much as an initial curvature that is wrong by half a per cent of
what 2 V do, which is ten times what its curves show.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from model.measurements import FloatArray, TimeSeries

# of the largest voltage of a run: from there on it is driven
DRIVEN_SHARE = 0.1
FEWEST_SAMPLES = 20
TOLD_V = 1e-3


def zero_voltage_V(series: Iterable[TimeSeries]) -> float:
    """Return the median voltage that was read back before the first pulses; 0 where none was."""
    each = [found for one in series if len(found := _before_pulses_V(one)) >= FEWEST_SAMPLES]
    return float(np.median([np.median(found) for found in each])) if each else 0.0


def _before_pulses_V(series: TimeSeries) -> FloatArray:
    """Return the samples before the first pulse; none where a run has no pulse."""
    drive = np.asarray(series.drive_V, dtype=np.float64)
    largest = float(np.max(np.abs(drive), initial=0.0, where=np.isfinite(drive)))
    driven = np.abs(drive) > DRIVEN_SHARE * largest
    if not driven.any():
        return drive[:0]
    before = drive[: int(np.argmax(driven))]
    return before[np.isfinite(before)]


def offset_note(series: Iterable[TimeSeries]) -> list[str]:
    """Return the sentence on such a voltage, where it is worth telling."""
    zero_V = zero_voltage_V(one for one in series if not one.extra)
    if abs(zero_V) < TOLD_V:
        return []
    told = f"{1e3 * zero_V:+.1f} mV reached the sheet (read back)"
    return [f"while 0 V was asked for, {told}: they count as so much of the EIBM"]
