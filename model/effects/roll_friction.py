"""The rolls rub on the sheet."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import MILLI, finite
from model.effects.interface import (
    BeamProblem,
    ContactSolution,
    Effect,
    EffectParameter,
    LoadCellInput,
    Values,
)
from model.effects.sliding import slid
from model.measurements import FloatArray

_JAM = 0.2  # of the contact force is left at least: beyond, the rolls would jam


@dataclass(frozen=True)
class RollFriction(Effect):
    """Coulomb's friction T = mu |N| along the sheet, against the way it was last slid.

    The force T t_hat on the sheet is the sum of one along the normal, T tan(gamma), and one along
    the radius of the arc, T/cos(gamma). The first is in what the load cell measures, so it belongs
    to the N that `ContactSolution` has; the other has no component along the arc. So shape and
    measured force are both right when one moment is added, that of the radial force.
    """

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        if p["force_alone"] > 0.5:
            return beam
        lean, outward = np.tan(contact.gamma_rad), p["coefficient"] * _way(slid(beam, contact), p)
        # N without friction's share of it
        pressed = np.abs(contact.normal_N)
        pressed = pressed / np.maximum(1.0 - outward * np.sign(contact.normal_N) * lean, _JAM)
        pressed = _pressed_N(pressed, p)
        rub = finite(outward * pressed / beam.stiffness)[:, None]
        moment = rub * (finite(lean)[:, None] * finite(contact.lever) + finite(contact.offset))
        return replace(beam, bend=beam.bend - moment)

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray:
        """See `Effect.force`."""
        if p["force_alone"] < 0.5:
            return np.zeros_like(weighed.force_N)
        rub = p["coefficient"] * _pressed_N(np.abs(weighed.normal_N), p)
        rub = rub * _way(np.asarray(weighed.slid), p)
        return np.asarray(-rub * np.sin(weighed.gamma_rad))


def _way(slid: FloatArray, p: Values) -> FloatArray:
    """Return the sense of the force: that of the sliding, or always the same."""
    always = p.get("one_way", 0.0)
    return slid if always == 0.0 else np.full_like(slid, always)


def _pressed_N(force_N: FloatArray, p: Values) -> FloatArray:
    """Return the force that friction goes with: the present one, or always the same."""
    always = p.get("at_force_mN", 0.0) * MILLI
    return np.full_like(force_N, always) if always > 0.0 else force_N


EFFECT = RollFriction(
    name="roll_friction",
    meaning="The sheet does not slide freely between the rolls of the load cell: they rub on it.",
    form=(
        "a force mu |N| along the sheet, against the way it last slid: under voltage from where the"
        " opposite voltage held it, at 0 V from the side from which the position was approached;"
        " 20 um of sliding turn it round; or always the same way, as of rolls that are driven or"
        " wound up; or mu times 1 mN, whatever the contact force"
    ),
    location="position",
    signature=(
        "An error of the force in proportion to |N| sin(gamma) that changes its sign with the sense"
        " of sliding, from one polarity to the other and with the side of approach."
    ),
    isolates="A position approached from both sides; a tap on the rig that frees the rolls.",
    source=(
        "Johnson 1985, Contact Mechanics; Dahl 1968, A Solid Friction Model, Aerospace Corp."
        " TOR-0158(3107-18); Harris 2001, Rolling Bearing Analysis (a bearing's friction has a part"
        " that does not go with its load); the paper takes the contact as frictionless"
    ),
    parameters=(
        EffectParameter(
            name="coefficient",
            meaning="tangential over normal force",
            unit="",
            prior_scale=0.1,
            low=0.0,
            high=1.0,
            instrument_limit=0.7,
            beyond="a coefficient of friction of {value} would not let the rolls slide",
        ),
        EffectParameter(
            name="force_alone",
            meaning="1: it is felt by the load cell and does not bend the sheet",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=1.0,
            starting_values=(0.0, 1.0),
        ),
        EffectParameter(
            name="at_force_mN",
            meaning="the contact force that it is as large as at; 0: the present one",
            unit="mN",
            prior_scale=0.0,
            low=0.0,
            high=1.0,
            starting_values=(0.0, 1.0),
        ),
        EffectParameter(
            name="one_way",
            meaning="0: against the way it last slid; 1: always towards the sheet's end; -1: always"
            " towards the clamp",
            unit="",
            prior_scale=0.0,
            low=-1.0,
            high=1.0,
            starting_values=(0.0, 1.0, -1.0),
        ),
    ),
    form_error_along=("position", "voltage", "approach"),
    by_history=True,
)
