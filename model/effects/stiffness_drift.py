"""The sheet becomes stiffer or softer while it is measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._drift import SETTLES_OR_GROWS, SINCE, Drift, progress
from model.effects.interface import AcquisitionTimes, EffectParameter, Values
from model.measurements import FloatArray

MOST = 2.2  # a dry sheet is stiffer than a wet one by no more than this factor


@dataclass(frozen=True)
class StiffnessDrift(Drift):
    """B changes linearly, 0 in the middle of the session."""

    def course(self, clock: AcquisitionTimes, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.course`."""
        change = p["relative_change"] * progress(clock, p)
        bounded = np.clip(change, 1.0 / MOST - 1.0, MOST - 1.0)
        return np.zeros_like(bounded), bounded


EFFECT = StiffnessDrift(
    name="stiffness_drift",
    meaning=(
        "The bending stiffness grows (or falls, when negative) while data are taken, because the"
        " water content of the sheet changes."
    ),
    form=(
        "B = mean x (1 + c (tau - 1/2)), tau = 0 to 1 over the session, all the time or only"
        " between the runs, or over 13.2 s under voltage since the last wetting; or settling"
        " exponentially with a third of that as its time constant, or faster and faster as the"
        " square of the time; of several sessions anew in each, or on through all of them; never by"
        " more than a factor of 2.2"
    ),
    location="time",
    signature=(
        "Forces grow or shrink in proportion with time at all voltages, shapes under voltage the"
        " other way round; the free shape at 0 V does not move."
    ),
    isolates="Random order of the positions; a position measured again at the end of the session.",
    source=(
        "Nemat-Nasser and Thomas 2004, in Bar-Cohen (ed.), Electroactive Polymer Actuators, 2nd"
        " ed., ch. 6 (stiffness against hydration); the paper, section 3.2"
    ),
    parameters=(
        EffectParameter(
            name="relative_change",
            meaning="of the stiffness over the session",
            unit="",
            prior_scale=0.1,
            low=-1.0,
            high=1.2,
            instrument_limit=0.6,
            beyond=(
                "a stiffness that changes by {value} of itself in a session would be seen where a"
                " position is measured again"
            ),
        ),
        SINCE,
        SETTLES_OR_GROWS,
    ),
    form_error_along=("time",),
)
