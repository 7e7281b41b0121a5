"""The sheet bends less, or more, at a negative voltage than at the same positive one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import MILLI
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values


@dataclass(frozen=True)
class EibmAsymmetry(Effect):
    """What is even in the voltage: as much more at one polarity as less at the other.

    The same all along the sheet, or falling from the clamp.
    """

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        even = (1.0 - p["ratio"]) / (1.0 + p["ratio"])
        along = np.ones_like(beam.s_m)
        if p["fall_mm"] > 0.0:
            along = np.exp(-beam.s_m / (p["fall_mm"] * MILLI))
            along *= np.sum(beam.piece_m) / np.sum(along * beam.piece_m)
        more = 1.0 + even * np.sign(beam.voltage_V)[:, None] * along
        return replace(beam, eibm=beam.eibm * more)


EFFECT = EibmAsymmetry(
    name="eibm_asymmetry",
    meaning=(
        "The EIBM at a negative voltage is not the mirror image of that at the positive one: its"
        " two electrodes, or its two faces, are not alike."
    ),
    form=(
        "Me(+V) = (1 + e) |Me|, Me(-V) = -(1 - e) |Me|, e = (1 - ratio)/(1 + ratio); the same along"
        " the sheet, or falling from the clamp with this mean"
    ),
    location="even_moment",
    signature=(
        "The mean of what +V and -V do differs from what 0 V does. Only a model in which one |EIBM|"
        " serves both polarities lacks it; the usual one has an EIBM for each."
    ),
    isolates="The free shapes at +V, 0 V and -V; the sheet turned over in the clamp.",
    source="the paper, section 4.2, observation 4: the asymmetry of the material",
    parameters=(
        EffectParameter(
            name="ratio",
            meaning="|EIBM| at negative over that at positive voltage",
            unit="",
            prior_scale=0.8,
            low=0.1,
            high=10.0,
            neutral=1.0,
            log=True,
        ),
        EffectParameter(
            name="fall_mm",
            meaning="length in which it falls to 1/e from the clamp; 0: it does not",
            unit="mm",
            prior_scale=0.0,
            low=0.0,
            high=1e3,
            starting_values=(0.0, 25.0),
        ),
    ),
    form_error_along=("s",),
    in_base_model=True,
    waves=7,
    by_configuration=True,
)
