"""How much of the EIBM a voltage has brought by a time."""

from __future__ import annotations

import numpy as np

from model.effects.interface import Clock
from model.measurements import FloatArray


def rise_left(clock: Clock, rise_s: float, later_s: float) -> FloatArray:
    """What is missing of the settled EIBM after a rise with this time constant, relative."""
    left: FloatArray = (1.0 - clock.opposite) * np.exp(-(clock.pulse_s + later_s) / rise_s)
    return np.where(clock.voltage_V != 0.0, left, 0.0)
