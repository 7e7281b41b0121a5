"""Whether the current channel shows the sheet's current, or an input without a wire."""

from __future__ import annotations

import numpy as np

from drivers.interfaces import FloatArray
from model.dynamics import HeldVoltage

BLOCK_S = 0.02  # a period of the mains, whose hum an open input shows
CHARGING_S = 0.15  # usual time in which a sheet charges
FEWEST_BLOCKS = 20
LEAST_SHARE = 0.2  # of the current's variance that follows the voltage; a sheet's: 0.7 and more


def follows_the_voltage(drive: HeldVoltage, time_s: FloatArray, current_A: FloatArray) -> bool:
    """Return whether a part of the current charges the sheet after an edge, or leaks through it.

    True where there is too little to judge by.
    """
    step_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else BLOCK_S
    length = max(1, round(BLOCK_S / step_s))
    count = len(time_s) // length
    if count < FEWEST_BLOCKS:
        return True
    blocks = (x[: count * length].reshape(count, length) for x in (time_s, current_A))
    at_s, found_A = (block.mean(axis=1) for block in blocks)
    volts = drive.at(at_s)
    if not np.ptp(volts):
        return True
    columns = np.stack([np.ones(count), volts, volts - _charged(drive, at_s)], axis=1)
    left = found_A - columns @ np.linalg.lstsq(columns, found_A, rcond=None)[0]
    return bool(np.var(left) < (1.0 - LEAST_SHARE) * np.var(found_A))


def _charged(drive: HeldVoltage, at_s: FloatArray) -> FloatArray:
    """Return the voltage of a capacitor that charges in `CHARGING_S`."""
    steps = np.diff(drive.voltage_V, prepend=0.0)
    since_s = np.maximum(0.0, at_s[:, None] - drive.time_s)
    return np.asarray(-np.expm1(-since_s / CHARGING_S) @ steps)
