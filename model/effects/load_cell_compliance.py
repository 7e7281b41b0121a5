"""The load cell yields to the force."""

from __future__ import annotations

from dataclasses import dataclass, replace

from model.effects._values import finite
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values


@dataclass(frozen=True)
class LoadCellCompliance(Effect):
    """The contact moves along the arc in proportion to the force along it."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        # 1 mm/mN is 1 m/N
        given_way = p["compliance_mm_per_mN"] * finite(contact.force_N)
        return replace(beam, shift_m=beam.shift_m + given_way)


EFFECT = LoadCellCompliance(
    name="load_cell_compliance",
    meaning="The load cell, or what carries it, gives way along the arc under the sheet's force.",
    form="p = stated p + c F",
    location="load_cell",
    signature=(
        "The contact stands a little farther on the side to which the sheet pushes, in proportion"
        " to the force; the stiffer short sheet seems softer than it is, the long one hardly."
    ),
    isolates="The contact in the picture beside the force; the cell pushed with a known weight.",
    source="Doebelin, Measurement Systems: Application and Design (stiffness of force cells)",
    parameters=(
        EffectParameter(
            name="compliance_mm_per_mN",
            meaning="way per force",
            unit="mm/mN",
            prior_scale=0.005,
            low=0.0,
            high=5.0,
            instrument_limit=3.0,
            beyond="rolls that give way by {value} mm per mN would be seen",
        ),
    ),
    form_error_along=("position",),
    of_the_rig=True,
)
