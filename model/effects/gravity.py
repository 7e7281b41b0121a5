"""The rig is not level: the sheet's own weight bends it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import finite
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values
from model.measurements import FloatArray


@dataclass(frozen=True)
class Gravity(Effect):
    """A load per length along -y, of both the sheet and its elongation."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        load = p["load_N_per_m"] * np.broadcast_to(beam.upright, beam.stiffness.shape)
        moment = -load[:, None] * arm(beam, contact)
        return replace(beam, bend=beam.bend + moment / beam.stiffness[:, None])


def arm(beam: BeamProblem, contact: ContactSolution) -> FloatArray:
    """Return integral of x(sigma) - x(s) from s to the visible end, m^2: (K, G).

    Between nodes by the trapezoid's rule corrected with the ends' slopes dx/ds = cos(phi); beyond
    the last one along a straight line.
    """
    s, x, slope = beam.s_m, contact.x_m, np.cos(contact.phi_rad)
    h = np.diff(s)
    panels = 0.5 * h * (x[:, 1:] + x[:, :-1]) + h**2 / 12.0 * (slope[:, :-1] - slope[:, 1:])
    beyond = np.cumsum(panels[:, ::-1], axis=1)[:, ::-1]
    beyond = np.concatenate([beyond, np.zeros_like(x[:, :1])], axis=1) - (s[-1] - s) * x
    tail = beam.sheet.free_length_m + beam.sheet.elongation_m - s[-1]
    beyond += tail * (x[:, -1:] - x) + 0.5 * tail**2 * np.cos(contact.end_phi_rad)[:, None]
    return finite(beyond)


EFFECT = Gravity(
    name="gravity",
    meaning=(
        "The rig is not level, and a part of the sheet's weight acts in the plane of the picture,"
        " towards negative deflection where the load is positive and the rig is not turned over."
    ),
    form=(
        "M(s) = -q cos(tilt) x integral of (x - x(s)) over what lies beyond s, elongation"
        " included; the tilt is that of the rig about the sheet's long axis"
    ),
    location="even_moment",
    signature=(
        "The same bending towards one side at every voltage, most near the clamp, and less where"
        " the sheet is rolled up; a force that hardly depends on position and voltage."
    ),
    isolates="The rig turned over: the load changes sign, a wrong zero or rest curvature does not.",
    source=(
        "Landau and Lifshitz, Theory of Elasticity, sections 19, 20; the paper, section 3.1: motion"
        " is horizontal so that gravity does not matter"
    ),
    parameters=(
        EffectParameter(
            name="load_N_per_m",
            meaning="weight per length that acts along -y",
            unit="N/m",
            prior_scale=0.005,
            low=-0.5,
            high=0.5,
            instrument_limit=0.1,
            beyond="a sheet that weighs {value} N/m would be denser than lead",
        ),
    ),
    form_error_along=("s",),
)
