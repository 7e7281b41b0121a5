"""How much of the EIBM a voltage has brought by a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.effects.interface import AcquisitionTimes
from model.measurements import FloatArray

SHORTEST_S = 1e-6  # time constant of a rise


def rise_left(clock: AcquisitionTimes, rise_s: FloatArray | float, later_s: float) -> FloatArray:
    """Return the relative deficit of the settled EIBM after a rise with this time constant."""
    since_s = np.maximum(clock.pulse_s + later_s, 0.0)  # before the edge it is what it was
    left: FloatArray = (1.0 - clock.opposite) * np.exp(-since_s / rise_s)
    return np.where(clock.voltage_V != 0.0, left, 0.0)


def older_picture(clock: AcquisitionTimes, age_s: float) -> FloatArray:
    """Return the relative change of the EIBM in an image that is older than its reading."""
    rise_s = np.maximum(clock.rise_s, SHORTEST_S)
    then, now = (1.0 - rise_left(clock, rise_s, later_s) for later_s in (-age_s, 0.0))
    return np.asarray(then / now - 1.0)


def through_zero(clock: AcquisitionTimes) -> AcquisitionTimes:
    """Return the times for an EIBM that follows the voltage through 0, each polarity in proportion.

    Otherwise it goes straight from one settled value to the other.
    """
    in_volts = np.where(np.isfinite(clock.opposite_V), clock.opposite_V, np.sign(clock.opposite))
    return replace(clock, opposite=in_volts)
