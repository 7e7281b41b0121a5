"""The load cell is not where the stage says."""

from __future__ import annotations

from dataclasses import dataclass, replace

from model.effects._values import MILLI
from model.effects.interface import Beam, Effect, Held, Knob, Values


@dataclass(frozen=True)
class PositionError(Effect):
    """All contacts farther along the arc by the same length."""

    def beam(self, beam: Beam, held: Held, p: Values) -> Beam:
        """See `Effect.beam`."""
        del held
        return replace(beam, shift_m=beam.shift_m + p["offset_mm"] * MILLI)


EFFECT = PositionError(
    name="position_error",
    meaning="The load cell stands farther along the arc than stated, everywhere by one length.",
    form="p = stated p + c",
    slot="position",
    signature=(
        "The held shapes are turned at the contact alike at all voltages, and the force is shifted"
        " by its slope times the error; free shapes are right."
    ),
    isolates="The contact's place in the picture; where the free sheet crosses the arc.",
    source="the paper, section 3.1: the load cell is repositioned by hand between experiments",
    knobs=(Knob("offset_mm", "true less stated position along the arc", "mm", 0.3, -10.0, 10.0),),
    tolerance=("position",),
    of_the_rig=True,
)
