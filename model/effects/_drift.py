"""How far a slow change has come."""

from __future__ import annotations

import numpy as np

from model.effects.interface import AcquisitionTimes, EffectParameter
from model.measurements import FloatArray

# The paper's 22 pulses of 0.6 s: the time under voltage over which a change since the last wetting
# is stated, however often the sheet was moistened.
RUN_DRIVEN_S = 13.2
SINCE = EffectParameter(
    name="since_wetting",
    meaning="0: over the whole session; 1: under voltage, since the last wetting",
    unit="",
    prior_scale=0.0,
    low=0.0,
    high=1.0,
    starting_values=(0.0, 1.0),
)
SETTLES = EffectParameter(
    name="settles",
    meaning="0: goes on evenly; 1: slows down, 95 % of it is over at the end",
    unit="",
    prior_scale=0.0,
    low=0.0,
    high=1.0,
    starting_values=(0.0, 1.0),
)
SETTLES_AFTER = 1.0 / 3.0  # its time constant, of the whole


def progress(clock: AcquisitionTimes, since_wetting: float, settles: float) -> FloatArray:
    """-1/2 at the beginning, 1/2 at the end: of the data, or of a run's time under voltage."""
    done = clock.driven_s / RUN_DRIVEN_S if since_wetting > 0.5 else clock.session
    if settles > 0.5:
        done = settled(done)
    return np.asarray(done - 0.5)


def settled(done: FloatArray) -> FloatArray:
    """0 to 1 over the whole, most of it soon."""
    return np.asarray(np.expm1(-done / SETTLES_AFTER) / np.expm1(-1.0 / SETTLES_AFTER))
