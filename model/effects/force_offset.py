"""A wrong zero of the load cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._values import MILLI
from model.effects.interface import Effect, EffectParameter, LoadCellInput, Values
from model.measurements import FloatArray


@dataclass(frozen=True)
class ForceOffset(Effect):
    """The same force added to every reading, whether the sheet is touched or not."""

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray:
        """See `Effect.force`."""
        return np.full_like(weighed.force_N, p["force_mN"] * MILLI)


EFFECT = ForceOffset(
    name="force_offset",
    meaning="The load cell's zero is too high by a constant force.",
    form="F measured = F + c",
    location="load_cell",
    signature=(
        "The same error of the force at every position and voltage, and in readings without"
        " contact; the shapes are right."
    ),
    isolates="A zero taken without touching the sheet.",
    source="Doebelin, Measurement Systems: Application and Design (zero drift of a force cell)",
    parameters=(
        EffectParameter(
            name="force_mN",
            meaning="what the cell shows without a load",
            unit="mN",
            prior_scale=0.05,
            low=-20.0,
            high=20.0,
        ),
    ),
    form_error_along=(),  # it has none: what wanders is a drift
    of_the_rig=True,
)
