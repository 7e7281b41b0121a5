"""The elongation bends too."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import finite
from model.effects.interface import (
    BeamProblem,
    ContactSolution,
    Effect,
    EffectParameter,
    ImagePoints,
    Values,
)
from model.measurements import FloatArray

IN_THE_JOINT, DRAWN_STRAIGHT = 1.0, 2.0  # values of `in_the_joint`
SPREAD = 5  # power of s/L in which a hinge at the end acts before it: its mean place is 6/7 L


@dataclass(frozen=True)
class ElongationFlexibility(Effect):
    """The elongation has a finite stiffness; the load bends it, the EIBM does not."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        if beam.sheet.elongation_m <= 0.0:
            return beam
        if p["in_the_joint"] == IN_THE_JOINT:
            return _hinged(beam, p["relative_compliance"])
        return replace(beam, elongation_soft=beam.elongation_soft + p["relative_compliance"])

    def curve(self, points: ImagePoints, p: Values) -> tuple[FloatArray, FloatArray] | None:
        """See `Effect.curve`: who takes the elongation as straight draws it so."""
        if p["in_the_joint"] != DRAWN_STRAIGHT:
            return None
        less_m = -p["relative_compliance"] * _bent_away_m(points)
        return less_m * points.normal_x, less_m * points.normal_y


def _bent_away_m(points: ImagePoints) -> FloatArray:
    """Return how far an elongation as soft as the sheet leaves the sheet's tangent: (K, S).

    Its curvature is -N/B times the lever of the load, to first order in the slope.
    """
    length_m = finite(np.asarray(points.contact_m) - points.free_length_m)
    length_m = np.maximum(length_m, 0.0)  # of what is bent: 0 where the sheet itself is touched
    away_m = np.maximum(points.s_m - points.free_length_m, 0.0)
    inside_m = np.minimum(away_m, length_m)
    levers = 0.5 * length_m * inside_m**2 - inside_m**3 / 6.0
    levers += 0.5 * length_m**2 * (away_m - inside_m)  # straight on from the contact
    return np.asarray(-finite(np.asarray(points.pressed_per_m2)) * levers)


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
        " end that lets the contact go as far; or the same, drawn straight in the picture"
    ),
    location="compliance",
    signature=(
        "Only with an elongation: it is bent in proportion to the force, most where it leaves the"
        " sheet, and the sheet seems softer than it is; or it is drawn straight in the picture, and"
        " does not pass the point of the arc where the load cell is."
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
            meaning=(
                "0: all of it is soft; 1: only the joint, and goes as far; 2: all of it is soft,"
                " but the picture is drawn straight on from the sheet's end"
            ),
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=2.0,
            starting_values=(0.0, IN_THE_JOINT, DRAWN_STRAIGHT),
        ),
    ),
    form_error_along=("position",),
)
