"""The arc on which the load cell moves is not the stated one about the clamp."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import MILLI
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values


@dataclass(frozen=True)
class ArcError(Effect):
    """All contacts farther from the clamp by the same length, or the arc's centre before it."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        R, along, c = beam.sheet.arc_radius_m, np.nan_to_num(beam.stated_m), p["offset_mm"] * MILLI
        if p["of"] > 1.5:  # the centre, before the clamp
            beta = along / R + beam.sheet.arc_origin_rad
            x, y = c + R * np.cos(beta), R * np.sin(beta)
            reach, shift = np.hypot(x, y) - R, R * (np.arctan2(y, x) - beta)
        else:  # the radius: the same length along the arc is a smaller angle
            reach, shift = np.full(along.shape, c), -along * c / (R + c) * (p["of"] < 0.5)
        return replace(beam, reach_m=beam.reach_m + reach, shift_m=beam.shift_m + shift)


EFFECT = ArcError(
    name="arc_error",
    meaning=(
        "The arc on which the load cell moves has another radius than stated, or its centre is not"
        " at the clamp."
    ),
    form=(
        "R = stated R + c, positions being lengths on the arc; or angles, of the stated R; or the"
        " centre is c before the clamp"
    ),
    location="position",
    signature=(
        "The sheet is touched farther from the clamp at every position and voltage: forces fall as"
        " with a longer lever, and held shapes are turned where they cross the arc askew; free"
        " shapes are right."
    ),
    isolates="The contact's place in the picture, from the clamp; free shapes.",
    source="the paper, section 3.1: the load cell is moved by hand along an arc about the clamp",
    parameters=(
        EffectParameter(
            name="offset_mm",
            meaning="true less stated distance of the contact from the clamp, at 0 mm",
            unit="mm",
            prior_scale=0.3,
            low=-10.0,
            high=10.0,
            instrument_limit=5.0,
            beyond="an arc {value} mm from its place would be seen with a ruler",
        ),
        EffectParameter(
            name="of",
            meaning="0: radius, positions are lengths; 1: radius, positions are angles; 2: centre",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=2.0,
            starting_values=(0.0, 1.0, 2.0),
        ),
    ),
    form_error_along=("position",),
    of_the_rig=True,
)
