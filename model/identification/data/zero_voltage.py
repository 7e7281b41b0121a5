"""The voltage that reaches the sheet while none is asked for, such as an amplifier's offset.

10 mV bend a sheet by half a per cent of what 2 V do; its curves show a tenth of that.
"""

from __future__ import annotations

import numpy as np

from model.measurements import FloatArray, Measurements

# of the smallest voltage that was asked for: from there on a sample is driven
DRIVEN_SHARE = 0.5
FEWEST_SAMPLES = 20
TOLD_V = 1e-3


def zero_voltage_V(measurements: Measurements, configuration: str = "") -> float:
    """Return the median voltage that was read back before the first pulses; 0 where none was.

    configuration: that of the runs; empty: of all.
    """
    asked_V = [abs(one.voltage_V) for one in measurements.conditions if one.voltage_V != 0.0]
    if not asked_V:
        return 0.0
    driven_V = DRIVEN_SHARE * min(asked_V)
    each = [
        _before_pulses_V(np.asarray(one.drive_V, dtype=np.float64), driven_V)
        for one in measurements.series
        if configuration in ("", one.configuration) and not one.extra
    ]
    known = [float(np.median(found)) for found in each if len(found) >= FEWEST_SAMPLES]
    return float(np.median(known)) if known else 0.0


def _before_pulses_V(drive_V: FloatArray, driven_V: float) -> FloatArray:
    """Return the samples before the first pulse; none where a run has no pulse."""
    driven = np.abs(drive_V) > driven_V
    if not driven.any():
        return drive_V[:0]
    before = drive_V[: int(np.argmax(driven))]
    return before[np.isfinite(before)]


def offset_note(measurements: Measurements) -> list[str]:
    """Return the sentence on such a voltage, where it is worth telling."""
    zero_V = zero_voltage_V(measurements)
    if abs(zero_V) < TOLD_V:
        return []
    told = f"{1e3 * zero_V:+.1f} mV reached the sheet (read back)"
    return [f"while 0 V was asked for, {told}: they count as so much of the EIBM"]
