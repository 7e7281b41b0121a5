"""The load cell's axis is not along the arc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._values import finite
from model.effects.interface import Effect, EffectParameter, LoadCellInput, Values
from model.measurements import FloatArray


@dataclass(frozen=True)
class LoadCellMisalignment(Effect):
    """The cell measures N cos(gamma - angle) where (5) has N cos(gamma)."""

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray:
        """See `Effect.force`."""
        gamma = weighed.gamma_rad
        seen = np.cos(gamma - p["angle_rad"]) - np.cos(gamma)
        return finite(weighed.normal_N * seen)


EFFECT = LoadCellMisalignment(
    name="load_cell_misalignment",
    meaning=(
        "The load cell's axis is turned from the tangent of the arc, counter-clockwise where the"
        " angle is positive, so that it feels a part of the force along the radius."
    ),
    form="F measured = N cos(gamma - angle)",
    location="load_cell",
    signature=(
        "An error of the force in proportion to N sin(gamma): of one sign where the sheet leans"
        " forward and of the other where it leans back; none where it crosses the arc squarely."
    ),
    isolates="A dead weight hung along the tangent, or the cell turned by a known angle.",
    source="the paper, section 3.2: the cell has to stand square to the tangent of the trajectory",
    parameters=(
        EffectParameter(
            name="angle_rad",
            meaning="from the arc's tangent to the cell's axis",
            unit="rad",
            prior_scale=0.05,
            low=-0.8,
            high=0.8,
            instrument_limit=0.6,
            beyond="a load cell turned by {degrees} degrees would be seen",
        ),
    ),
    form_error_along=("position",),
    of_the_rig=True,
)
