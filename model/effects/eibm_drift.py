"""The EIBM grows or falls during the session."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._drift import SETTLES_OR_GROWS, SINCE, Drift, progress
from model.effects.interface import AcquisitionTimes, EffectParameter, Values
from model.measurements import FloatArray

LEAST = 0.05  # of the EIBM is always left


@dataclass(frozen=True)
class EibmDrift(Drift):
    """The EIBM changes linearly, 0 in the middle of the session."""

    def course(self, clock: AcquisitionTimes, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.course`."""
        change = p["relative_change"] * progress(clock, p)
        bounded = np.maximum(change, LEAST - 1.0)
        return bounded, np.zeros_like(bounded)


EFFECT = EibmDrift(
    name="eibm_drift",
    meaning=(
        "The EIBM grows (falls, when negative) while data are taken: the sheet loses water, or its"
        " electrodes wear."
    ),
    form=(
        "Me = mean x (1 + c (tau - 1/2)), tau = 0 to 1 over the session, all the time or only"
        " between the runs, or over 13.2 s under voltage since the last wetting; or settling"
        " exponentially, with a third of that as its time constant, or faster and faster as the"
        " square of the time; of several sessions anew in"
        " each, or on through all of them"
    ),
    location="time",
    signature=(
        "What the voltage does to force and shape grows or shrinks with time; readings at 0 V stay"
        " as they are."
    ),
    isolates="Random order of the positions; a position measured again at the end of the session.",
    source=(
        "Nemat-Nasser and Thomas 2004, in Bar-Cohen (ed.), Electroactive Polymer Actuators, 2nd"
        " ed., ch. 6 (response against hydration); the paper, section 3.2"
    ),
    parameters=(
        EffectParameter(
            name="relative_change",
            meaning="of the EIBM over the session",
            unit="",
            prior_scale=0.1,
            low=-1.5,
            high=3.0,
            instrument_limit=0.6,
            beyond=(
                "an EIBM that changes by {value} of itself in a session would be seen where a"
                " position is measured again"
            ),
        ),
        SINCE,
        SETTLES_OR_GROWS,
    ),
    form_error_along=("time",),
)
