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

BETWEEN_RUNS = 2  # value of the next one
SINCE = EffectParameter(
    name="since_wetting",
    meaning=(
        "0: over the whole session; 1: under voltage, since the last wetting; 2: over the session,"
        " between the runs alone"
    ),
    unit="",
    prior_scale=0.0,
    low=0.0,
    high=2.0,
    starting_values=(0.0, 1.0, float(BETWEEN_RUNS)),
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
SETTLES_OR_GROWS = replace(
    SETTLES,
    meaning=f"{SETTLES.meaning}; -1: faster and faster, as the square of the time",
    low=-1.0,
    starting_values=(0.0, 1.0, -1.0),
)


@dataclass(frozen=True)
class Drift(Effect):
    """A slow change over the session."""

    def for_sessions(self, count: int) -> Effect | None:
        """See `Effect.for_sessions`: one session does not say what the next begins with."""
        return self if count < 2 else replace(self, parameters=(*self.parameters, GOES_ON))

    def in_order_of_positions(self) -> Effect:
        """See `Effect`: a change between the runs alone is one between the positions there."""
        return replace(self, parameters=tuple(map(_not_between_runs, self.parameters)))


def _not_between_runs(parameter: EffectParameter) -> EffectParameter:
    if parameter.name != SINCE.name:
        return parameter
    return replace(parameter, starting_values=SINCE.starting_values[:BETWEEN_RUNS])


def over_session(times: AcquisitionTimes | LoadCellInput, p: Values) -> FloatArray:
    """0 to 1: over the session, or over all of them where the change goes on."""
    if p.get(GOES_ON.name, 0.0) <= 0.5:
        return np.asarray(times.session)
    return np.array(np.broadcast_to(times.overall, np.shape(times.session)))


def progress(clock: AcquisitionTimes, p: Values) -> FloatArray:
    """-1/2 at the beginning, 1/2 at the end: of the session, or of a run's time under voltage."""
    since, settles = p[SINCE.name], p[SETTLES.name]
    if since > BETWEEN_RUNS - 0.5:
        done = as_the_run_began(clock, p)
    elif since > 0.5:
        done = clock.driven_s / DRIVEN_S
    else:
        done = over_session(clock, p)
    if settles > 0.5:
        done = settled(done)
    elif settles < -0.5:
        done = done**2
    return np.asarray(done - 0.5)


def as_the_run_began(clock: AcquisitionTimes, p: Values) -> FloatArray:
    """Return what had been done when each run began; where that is not known, what is done.

    It is known as a share of the run's own session, not of all of them.
    """
    done = over_session(clock, p)
    own = np.isfinite(clock.run_began) & (p.get(GOES_ON.name, 0.0) <= 0.5)
    return np.where(own, clock.run_began, done)


def settled(done: FloatArray) -> FloatArray:
    """0 to 1 over the whole, most of it soon."""
    return np.asarray(np.expm1(-done / SETTLES_AFTER) / np.expm1(-1.0 / SETTLES_AFTER))
