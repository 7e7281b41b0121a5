"""The sheet is not equally stiff everywhere."""

from __future__ import annotations

from dataclasses import dataclass, replace

from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values


@dataclass(frozen=True)
class NonuniformStiffness(Effect):
    """B(s) on a straight line, with B in the middle of the measured free length."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        change = p["relative_change"]
        stiffness = 1.0 + change * beam.material_m / beam.material_length_m
        return replace(beam, soft=beam.soft * (1.0 + 0.5 * change) / stiffness)


EFFECT = NonuniformStiffness(
    name="nonuniform_stiffness",
    meaning=(
        "The bending stiffness grows from the clamp to the end of the free length (falls, when"
        " negative): thickness, electrodes or water differ along the sheet."
    ),
    form="B(s) = B (1 + c s/l)/(1 + c/2), c = B(l)/B(0) - 1",
    location="compliance",
    signature=(
        "With c positive a held sheet bends more near the clamp and less near its end than its"
        " force explains, at 0 V too; under voltage the EIBM seems to fall along the sheet as well."
    ),
    isolates="Held shapes at 0 V with a large force beside the free shape at 0 V.",
    source=(
        "the paper, section 4.2: the part surrounded by water is softer; Nemat-Nasser and Thomas"
        " 2004, in Bar-Cohen (ed.), Electroactive Polymer Actuators, 2nd ed., ch. 6"
    ),
    parameters=(
        EffectParameter(
            name="relative_change",
            meaning="of the stiffness, end to root",
            unit="",
            prior_scale=0.15,
            low=-0.9,
            high=9.0,
        ),
    ),
    form_error_along=("s",),
    waves=7,  # a step is as likely as a line
    by_configuration=True,
)
