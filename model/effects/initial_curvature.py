"""The initial curvature differs from that in sheet.toml."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values
from model.measurements import FloatArray, length_scale

FLAT_PER_M = 0.1  # mean of k0 below which nothing is in proportion to it


@dataclass(frozen=True)
class InitialCurvature(Effect):
    """A change of k0, the same from the clamp to the end, or all of it by the same factor."""

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        del contact
        shape = 1.0 + p["like_stated"] * (_like_stated(beam) - 1.0)
        return replace(beam, rest=beam.rest + p["curvature_error_per_m"] * shape)


def _like_stated(beam: BeamProblem) -> FloatArray:
    """Return the stated k0 over its mean, (G,); 1 where there is none."""
    stated = beam.sheet.initial_curvature
    if stated is None:
        return np.ones_like(beam.s_m)
    k0 = np.interp(beam.s_m, *stated)
    mean = float(np.sum(k0 * beam.piece_m) / np.sum(beam.piece_m))
    return k0 / mean if abs(mean) > FLAT_PER_M / length_scale(beam.sheet) else np.ones_like(k0)


EFFECT = InitialCurvature(
    name="initial_curvature",
    meaning=(
        "The sheet at rest is more curved than stated, in the direction of positive deflection."
    ),
    form="k0(s) = stated k0(s) + c; or stated k0(s) x (1 + c/mean of it)",
    location="rest_curvature",
    signature=(
        "The same turn of the free shape at every voltage, 0 V too, and with it a force that is"
        " shifted alike at all voltages."
    ),
    isolates="A free shape at 0 V, with no load cell near the sheet.",
    source="the paper, table 3: the sheets have an initial curvature, measured once per sheet",
    parameters=(
        EffectParameter(
            name="curvature_error_per_m",
            meaning="curvature at rest less that stated",
            unit="1/m",
            prior_scale=1.0,
            low=-60.0,
            high=60.0,
        ),
        EffectParameter(
            name="like_stated",
            meaning="0: the same everywhere; 1: in proportion to the stated one, whose mean"
            " is off by it",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=1.0,
            starting_values=(0.0, 1.0),
        ),
    ),
    form_error_along=("s",),
    waves=7,
    by_configuration=True,
)
