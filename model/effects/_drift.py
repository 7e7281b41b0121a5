"""How far a slow change has come."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects.between_sessions import GOES_ON
from model.effects.interface import (
    AcquisitionTimes,
    Effect,
    EffectParameter,
    LoadCellInput,
    Values,
)
from model.measurements import FloatArray
from model.measurements.pulse_train import DRIVEN_S

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


@dataclass(frozen=True)
class Drift(Effect):
    """A slow change over the session."""

    def for_sessions(self, count: int) -> Effect | None:
        """See `Effect.for_sessions`: one session does not say what the next begins with."""
        return self if count < 2 else replace(self, parameters=(*self.parameters, GOES_ON))


def over_session(times: AcquisitionTimes | LoadCellInput, p: Values) -> FloatArray:
    """0 to 1: over the session, or over all of them where the change goes on."""
    if p.get(GOES_ON.name, 0.0) <= 0.5:
        return np.asarray(times.session)
    return np.array(np.broadcast_to(times.overall, np.shape(times.session)))


def progress(clock: AcquisitionTimes, p: Values) -> FloatArray:
    """-1/2 at the beginning, 1/2 at the end: of the session, or of a run's time under voltage."""
    wetted = p[SINCE.name] > 0.5
    done = clock.driven_s / DRIVEN_S if wetted else over_session(clock, p)
    if p[SETTLES.name] > 0.5:
        done = settled(done)
    return np.asarray(done - 0.5)


def settled(done: FloatArray) -> FloatArray:
    """0 to 1 over the whole, most of it soon."""
    return np.asarray(np.expm1(-done / SETTLES_AFTER) / np.expm1(-1.0 / SETTLES_AFTER))
