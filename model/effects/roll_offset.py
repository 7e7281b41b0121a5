"""The point that moves on the arc is not on the sheet's neutral curve."""

from __future__ import annotations

from dataclasses import dataclass, replace

from model.effects._values import MILLI
from model.effects.interface import Beam, Effect, Held, Knob, Values


@dataclass(frozen=True)
class RollOffset(Effect):
    """A constant distance along the sheet's normal."""

    def beam(self, beam: Beam, held: Held, p: Values) -> Beam:
        """See `Effect.beam`."""
        del held
        return replace(beam, offset_m=beam.offset_m + p["offset_mm"] * MILLI)


EFFECT = RollOffset(
    name="roll_offset",
    meaning=(
        "The rolls hold the sheet beside the point that moves on the arc, by the roll's radius or"
        " half the sheet's thickness; positive when that point lies on the sheet's left."
    ),
    form="r(s_hat) + c n_hat = p_hat",
    slot="position",
    signature=(
        "As a wrong position where the sheet crosses the arc squarely; where it leans, the radius"
        " of the arc seems to change as well."
    ),
    isolates="The contact in the picture beside the stage's position, at several positions.",
    source="the paper, section 3.1: the sheet is held between two rolls of finite size",
    knobs=(
        Knob("offset_mm", "from the neutral curve to the arc's point, along the normal", "mm", 0.3,
             -5.0, 5.0),
    ),
    tolerance=("position",),
)  # fmt: skip
