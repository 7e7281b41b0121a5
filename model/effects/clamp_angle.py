"""The sheet leaves the clamp in another direction."""

from __future__ import annotations

from dataclasses import dataclass, replace

from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values


@dataclass(frozen=True)
class ClampAngle(Effect):
    """The same turn in every condition."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        return replace(beam, tilt_rad=beam.tilt_rad + p["angle_rad"])


EFFECT = ClampAngle(
    name="clamp_angle",
    meaning=(
        "The sheet leaves the clamp at an angle to the direction from which positions and pictures"
        " are counted, counter-clockwise where it is positive."
    ),
    form="phi(0) = c",
    location="rest_curvature",
    signature=(
        "Shapes that are turned about the clamp, free ones by the angle itself, from the clamp on;"
        " a wrong rest curvature begins to show only farther out."
    ),
    isolates="A free shape, its first millimetres in the picture.",
    source="Bisshopp and Drucker 1945, Quart. Appl. Math. 3, 272 (the clamped end's condition)",
    parameters=(
        EffectParameter(
            name="angle_rad",
            meaning="direction at the clamp",
            unit="rad",
            prior_scale=0.01,
            low=-0.5,
            high=0.5,
            instrument_limit=0.17,
            beyond="a clamp turned by {degrees} degrees would be seen",
        ),
    ),
    form_error_along=("position",),
)
