"""The arc on which the load cell moves is not the stated one about the clamp."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import MILLI
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values

# from the clamp to the arc's centre, which may be anywhere; the size has either sign
TOWARDS_DEG = range(0, 180, 15)
OF = (
    "radius, positions are lengths", "radius, positions are angles",
    *(f"centre, at {towards} degrees of the arc" for towards in TOWARDS_DEG),
)  # fmt: skip


@dataclass(frozen=True)
class ArcError(Effect):
    """All contacts farther from the clamp by the same length, or the arc's centre beside it."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        R, along, c = beam.sheet.arc_radius_m, np.nan_to_num(beam.stated_m), p["offset_mm"] * MILLI
        if p["of"] > 1.5:  # the centre, by its direction from the clamp
            beta = along / R + beam.sheet.arc_origin_rad
            towards = np.radians(TOWARDS_DEG[round(p["of"]) - 2])
            x, y = R * np.cos(beta) + c * np.cos(towards), R * np.sin(beta) + c * np.sin(towards)
            turned = np.remainder(np.arctan2(y, x) - beta + np.pi, 2.0 * np.pi) - np.pi
            reach, shift = np.hypot(x, y) - R, R * turned
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
        " centre is c from the clamp, towards 0, 15, ... or 165 degrees of the arc"
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
            meaning="true less stated radius, or how far the centre is from the clamp",
            unit="mm",
            prior_scale=0.3,
            low=-10.0,
            high=10.0,
            instrument_limit=5.0,
            beyond="an arc {value} mm from its place would be seen with a ruler",
        ),
        EffectParameter(
            name="of",
            meaning="; ".join(f"{number}: {text}" for number, text in enumerate(OF)),
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=len(OF) - 1.0,
            starting_values=tuple(map(float, range(len(OF)))),
        ),
    ),
    form_error_along=("position",),
    of_the_rig=True,
)
