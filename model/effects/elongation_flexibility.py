"""The elongation bends too."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values

SPREAD = 5  # power of s/L in which a hinge at the end acts before it: its mean place is 6/7 L


@dataclass(frozen=True)
class ElongationFlexibility(Effect):
    """The elongation has a finite stiffness; the load bends it, the EIBM does not."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        if beam.sheet.elongation_m <= 0.0:
            return beam
        if p["in_the_joint"] > 0.5:
            return _hinged(beam, p["relative_compliance"])
        return replace(beam, elongation_soft=beam.elongation_soft + p["relative_compliance"])


def _hinged(beam: BeamProblem, compliance: float) -> BeamProblem:
    """Return the beam with a hinge at the end of its free length; the contact may lie beyond it.

    A load F at the lever L bends what is c times as soft as the sheet by c F L^3/3B, and turns a
    hinge of the compliance h/B by F L h/B. Only the load turns it: the EIBM ends with the sheet.

    The hinge is spread over the sheet's end, in proportion to (s/L)^5: values at a single node
    would be a polynomial between the nodes that is negative there where the hinge is soft.
    """
    radius_m, joint_m = beam.sheet.arc_radius_m, beam.material_length_m
    if joint_m >= radius_m:  # measured without an elongation: the joint is this sheet's own
        joint_m = beam.sheet.free_length_m
    lever = radius_m - joint_m
    end = (beam.s_m / beam.sheet.free_length_m) ** SPREAD
    hinge_m = compliance * lever / 3.0
    more = np.broadcast_to(hinge_m * end / float(beam.piece_m @ end), beam.soft.shape)
    return replace(beam, soft=beam.soft + more, rest=beam.rest - more * (beam.eibm + beam.bend))


EFFECT = ElongationFlexibility(
    name="elongation_flexibility",
    meaning="The elongation, taken as rigid, gives way to the load on it.",
    form=(
        "k = c M/B beyond the free length, c = B over the elongation's stiffness; or a hinge at its"
        " end that lets the contact go as far"
    ),
    location="compliance",
    signature=(
        "Only with an elongation: it is bent in proportion to the force, most where it leaves the"
        " sheet, and the sheet seems softer than it is."
    ),
    isolates="The elongation's shape in the picture, held against free.",
    source=(
        "the paper, section 2, takes the elongation as absolutely rigid; Timoshenko and Gere 1972,"
        " Mechanics of Materials (bending of a cantilever)"
    ),
    parameters=(
        EffectParameter(
            name="relative_compliance",
            meaning="the sheet's stiffness over the elongation's",
            unit="",
            prior_scale=0.02,
            low=0.0,
            high=2.0,
        ),
        EffectParameter(
            name="in_the_joint",
            meaning="0: all of it is soft; 1: only the joint, and goes as far",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=1.0,
            starting_values=(0.0, 1.0),
        ),
    ),
    form_error_along=("position",),
)
