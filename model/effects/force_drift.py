"""The load cell's zero wanders in the course of the session."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._drift import SETTLES, Drift, over_session, settled
from model.effects._values import MILLI
from model.effects.interface import EffectParameter, LoadCellInput, Values
from model.measurements import FloatArray

TARED_AT = EffectParameter(
    name="tared_at",
    meaning="0: at the session's start; 0.25: a quarter into it; 0.5: in its middle; 0.75: a"
    " quarter before its end; 1: at its end",
    unit="",
    prior_scale=0.0,
    low=0.0,
    high=1.0,
    starting_values=(0.0, 0.25, 0.5, 0.75, 1.0),
)


@dataclass(frozen=True)
class ForceDrift(Drift):
    """A straight line over the session, 0 when the cell was set to zero."""

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray:
        """See `Effect.force`."""
        done, tared = over_session(weighed, p), np.array(p.get(TARED_AT.name, 0.0))
        if p[SETTLES.name] > 0.5:
            done, tared = settled(done), settled(tared)
        return np.asarray(p["force_mN"] * MILLI * (done - tared))


EFFECT = ForceDrift(
    name="force_drift",
    meaning="The load cell's zero rises (falls, when negative) as the session goes on.",
    form=(
        "F measured = F + c (tau - tau0), tau = 0 to 1 over the session, tau0 when the cell was"
        " tared; or settling exponentially, with a third of the session as its time constant; of"
        " several sessions anew in each, or on through all of them"
    ),
    location="load_cell",
    signature=(
        "An error of the force that goes with the time of day and nothing else; where positions are"
        " measured in their order, it looks like a wrong slope of the force."
    ),
    isolates="A zero without contact at each position; random order of the positions.",
    source="OIML R 60, Metrological regulation for load cells (zero drift, temperature)",
    needs_session=True,
    parameters=(
        EffectParameter(
            name="force_mN",
            meaning="zero at the session's end less that at its start",
            unit="mN",
            prior_scale=0.1,
            low=-20,
            high=20,
        ),
        SETTLES,
        TARED_AT,
    ),
    form_error_along=("session",),
    of_the_rig=True,
)
