"""The point that moves on the arc is not on the sheet's neutral curve."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import MILLI, finite
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values
from model.measurements import load_scale

TURNS_N = 5e-5  # of the contact force within which the sheet changes from roll to roll


@dataclass(frozen=True)
class RollOffset(Effect):
    """A distance along the sheet's normal: the same always, or towards the roll that is pressed."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        turns_N = TURNS_N * load_scale(beam.sheet, beam.stiffness)
        side = np.tanh(finite(contact.normal_N) / turns_N) if p["at_the_pressed"] > 0.5 else 1.0
        return replace(beam, offset_m=beam.offset_m + p["offset_mm"] * MILLI * side)


EFFECT = RollOffset(
    name="roll_offset",
    meaning=(
        "The rolls hold the sheet beside the point that moves on the arc, by the roll's radius or"
        " half the sheet's thickness; positive when that point lies on the sheet's left."
    ),
    form="r(s_hat) + c n_hat = p_hat; or c sign(N), from one roll to the other",
    location="position",
    signature=(
        "As a wrong position where the sheet crosses the arc squarely; where it leans, the radius"
        " of the arc seems to change as well. With play between the rolls the position is wrong by"
        " as much to the other side where the sheet presses the other way."
    ),
    isolates="The contact in the picture beside the stage's position, at several positions.",
    source="the paper, section 3.1: the sheet is held between two rolls of finite size",
    parameters=(
        EffectParameter(
            name="offset_mm",
            meaning="from the neutral curve to the arc's point, along the normal",
            unit="mm",
            prior_scale=0.3,
            low=-5.0,
            high=5.0,
            instrument_limit=4.0,
            beyond="a contact {value} mm off the curve would be seen: the rolls are smaller",
        ),
        EffectParameter(
            name="at_the_pressed",
            meaning="0: always on the same side; 1: on that of the roll that is pressed",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=1.0,
            starting_values=(0.0, 1.0),
        ),
    ),
    form_error_along=("position",),
    of_the_rig=True,
)
