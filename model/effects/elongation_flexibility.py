"""The elongation bends too."""

from __future__ import annotations

from dataclasses import dataclass, replace

from model.effects.interface import Beam, Effect, Held, Knob, Values


@dataclass(frozen=True)
class ElongationFlexibility(Effect):
    """The elongation has a finite stiffness; the load bends it, the EIBM does not."""

    def beam(self, beam: Beam, held: Held, p: Values) -> Beam:
        """See `Effect.beam`."""
        del held
        if beam.sheet.elongation_m <= 0.0:
            return beam
        return replace(beam, elongation_soft=beam.elongation_soft + p["relative_compliance"])


EFFECT = ElongationFlexibility(
    name="elongation_flexibility",
    meaning="The elongation, taken as rigid, gives way to the load on it.",
    form="k = c M/B beyond the free length, c = B over the elongation's stiffness",
    slot="compliance",
    signature=(
        "Only with an elongation: it is bent in proportion to the force, most where it leaves the"
        " sheet, and the sheet seems softer than it is."
    ),
    isolates="The elongation's shape in the picture, held against free.",
    source=(
        "the paper, section 2, takes the elongation as absolutely rigid; Timoshenko and Gere 1972,"
        " Mechanics of Materials (bending of a cantilever)"
    ),
    knobs=(
        Knob(
            "relative_compliance", "the sheet's stiffness over the elongation's", "", 0.02,
            low=0.0, high=2.0,
        ),
    ),
    tolerance=("position",),
)  # fmt: skip
