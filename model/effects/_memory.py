"""Memory of earlier pulses: lags behind alternating voltages."""

from __future__ import annotations

import numpy as np

from model.effects.interface import AcquisitionTimes, EffectParameter
from model.measurements import FloatArray
from model.measurements.pulse_train import PULSE_S

SPREAD = EffectParameter(
    name="spread",
    meaning="1: one time constant; more: three of them, apart by this factor",
    unit="",
    prior_scale=1.0,
    low=1.0,
    high=100.0,
    starting_values=(1.0, 5.0),
)


def before_edge(clock: AcquisitionTimes, tau_s: float, opposite: FloatArray | float) -> FloatArray:
    """Return a lag's value as the present pulse began, relative to its present aim.

    It begins at rest, behind pulses of which each aims at `opposite` times the next one's aim.
    """
    n, forgotten = np.maximum(clock.pulse, 0.0), np.exp(-PULSE_S / tau_s)
    settled = opposite * (1.0 - forgotten) / (1.0 + forgotten)
    # (-forgotten)^n, n whole numbers: NumPy's power is ten times slower
    swings = np.where(n.astype(np.int64) % 2, -1.0, 1.0) * np.exp(-PULSE_S / tau_s * n)
    return np.asarray(np.where(n > 0.0, settled * (1.0 - swings), 0.0))


def lagging(clock: AcquisitionTimes, tau_s: float, opposite: FloatArray | float) -> FloatArray:
    """Return where it is at these times, over where it goes."""
    left = np.exp(-np.maximum(clock.pulse_s, 0.0) / tau_s)
    return np.asarray(before_edge(clock, tau_s, opposite) * left + 1.0 - left)


def spread_about(tau_s: float, spread: float) -> FloatArray:
    """Time constants of a process that has several: three, apart by a factor; one without."""
    if spread == 1.0:
        return np.array([tau_s])
    return tau_s * np.array([1.0 / spread, 1.0, spread])
