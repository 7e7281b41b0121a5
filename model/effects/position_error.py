"""The load cell's position differs from the stage's."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import MILLI
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values
from model.measurements import length_scale

FAR_M = 0.03  # the farthest position, on an arc of the paper's size


@dataclass(frozen=True)
class PositionError(Effect):
    """All contacts farther along the arc by the same length, or in proportion to the position."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        far = np.nan_to_num(beam.stated_m) / (FAR_M * length_scale(beam.sheet))
        share = 2.0 * far - 1.0 if p["scale"] > 1.5 else far if p["scale"] > 0.5 else 1.0
        return replace(beam, shift_m=beam.shift_m + p["offset_mm"] * MILLI * share)


EFFECT = PositionError(
    name="position_error",
    meaning=(
        "The load cell stands farther along the arc than stated, by one length, or its scale is"
        " wrong."
    ),
    form="p = stated p + c; or + c p/30 mm; or + c (p/15 mm - 1)",
    location="position",
    signature=(
        "The held shapes are turned at the contact alike at all voltages, and the force is shifted"
        " by its slope times the error; free shapes are right."
    ),
    isolates="The contact's place in the picture; where the free sheet crosses the arc.",
    source="the paper, section 3.1: the load cell is repositioned by hand between experiments",
    parameters=(
        EffectParameter(
            name="offset_mm",
            meaning=(
                "true less stated position along the arc, at 30 mm; on arcs far from 40 mm, at"
                " three quarters of the radius"
            ),
            unit="mm",
            prior_scale=0.3,
            low=-10.0,
            high=10.0,
            instrument_limit=5.0,
            beyond="positions wrong by {value} mm would be seen on the scale of the arc",
        ),
        EffectParameter(
            name="scale",
            meaning="0: the same everywhere; 1: in proportion to the position; 2: none half-way",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=2.0,
            starting_values=(0.0, 1.0, 2.0),
        ),
    ),
    form_error_along=("position",),
    of_the_rig=True,
)
