"""The sheet bends less, or more, at a negative voltage than at the same positive one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import MILLI
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values

SIDES = (0.0, 1.0, -1.0)  # to look for where each polarity has an EIBM


@dataclass(frozen=True)
class EibmAsymmetry(Effect):
    """As much more at one polarity as less at the other, or a change at one polarity alone.

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
        polarity, side = np.sign(beam.voltage_V)[:, None], p.get("side", 0.0)
        # at one polarity alone the change is that of both
        acting = polarity if side == 0.0 else 2.0 * polarity * (polarity == side)
        more = 1.0 + even * acting * along
        return replace(beam, eibm=beam.eibm * more)

    def outside_base(self) -> Effect | None:
        """See `Effect.outside_base`: with an EIBM of each voltage only what is uneven is left."""
        size, fall, side = self.parameters
        uneven = tuple(v for v in fall.starting_values if v > 0.0)
        sides = replace(side, starting_values=SIDES)
        return replace(self, parameters=(size, replace(fall, starting_values=uneven), sides))


EFFECT = EibmAsymmetry(
    name="eibm_asymmetry",
    meaning=(
        "The EIBM at a negative voltage is not the mirror image of that at the positive one: its"
        " two electrodes, or its two faces, are not alike."
    ),
    form=(
        "Me(+V) = (1 + e) |Me|, Me(-V) = -(1 - e) |Me|, e = (1 - ratio)/(1 + ratio); the same along"
        " the sheet, or falling from the clamp with this mean; or 1 + 2 e, or 1 - 2 e, at one"
        " polarity alone"
    ),
    location="even_moment",
    needs_both_polarities=True,
    signature=(
        "The mean of what +V and -V do differs from what 0 V does. The usual base model has an EIBM"
        " of each polarity, and lacks only what is not the same all along the sheet."
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
        EffectParameter(
            name="side",
            meaning="0: at both polarities; 1: at positive voltage alone; -1: at negative alone",
            unit="",
            prior_scale=0.0,
            # where one |EIBM| serves both polarities, one of them alone cannot be told
            starting_values=(0.0,),
        ),
    ),
    form_error_along=("s",),
    in_base_model=True,
    waves=7,
    by_configuration=True,
)
