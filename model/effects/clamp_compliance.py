"""The clamped end of the sheet turns with the moment on it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import finite
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values


@dataclass(frozen=True)
class ClampCompliance(Effect):
    """The direction at the clamp turns by c M(0).

    M(0) is the moment of the contact force about the clamp. The arc is centred there, so that its
    lever is R cos(gamma), and M(0) = -R F.
    """

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        moment = -beam.sheet.arc_radius_m * finite(contact.normal_N * np.cos(contact.gamma_rad))
        return replace(beam, tilt_rad=beam.tilt_rad + p["rotation_rad_per_Nm"] * moment)


EFFECT = ClampCompliance(
    name="clamp_compliance",
    meaning=(
        "The clamp does not hold the sheet's direction: its end in the clamp turns with the moment"
        " of the load, as a hinge with a spring does."
    ),
    form="phi(0) = c M(0), with the load's moment M(0) = -R F at the clamp",
    location="compliance",
    signature=(
        "A turn of the whole sheet in proportion to the force, none where nothing touches it; the"
        " short sheet, whose bending gives way less, seems the softer of the two."
    ),
    isolates="Free shapes (no moment, no turn) beside held ones; a dead weight on the sheet.",
    source=(
        "O'Donnell 1960, J. Appl. Mech. 27, 461 (deflection of a cantilever due to the elasticity"
        " of its support)"
    ),
    parameters=(
        EffectParameter(
            name="rotation_rad_per_Nm",
            meaning="turn of the clamped end per moment of the load",
            unit="rad/(N m)",
            prior_scale=20.0,
            low=0.0,
            high=2e4,
            instrument_limit=5000.0,
            beyond="a clamp that turns by {value} rad per N m would be seen to give way",
        ),
    ),
    form_error_along=("position", "voltage"),
)
