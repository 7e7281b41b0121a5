"""The load cell shows less while the load grows than while it falls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._loop import hung
from model.effects._values import MILLI
from model.effects.interface import Effect, EffectParameter, LoadCellInput, Values
from model.measurements import FloatArray

FROM_NO_LOAD, GOES_ON = 1, 2


@dataclass(frozen=True)
class LoadCellHysteresis(Effect):
    """A play of half the height `force_mN`: the reading hangs behind the load."""

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray:
        """See `Effect.force`."""
        load = np.where(weighed.touching > 0.0, weighed.force_N, 0.0)
        begins = round(p["from_no_load"])
        height = p["force_mN"] * MILLI
        reach = p["reach_mN"] * MILLI or height
        if reach == 0.0:
            return np.zeros_like(load)
        behind = hung(
            load, weighed.position_m, reach,
            from_no_load=begins == FROM_NO_LOAD, goes_on=begins == GOES_ON,
        )  # fmt: skip
        return -height / reach * behind


EFFECT = LoadCellHysteresis(
    name="load_cell_hysteresis",
    meaning="The load cell hangs behind its load: it shows too little as the load grows, too much"
    " as it falls.",
    form="F measured = F - c sign(last change of F), once F has changed by more than c;"
    " or by more than the loop's reach",
    location="load_cell",
    signature=(
        "The forces of the two polarities lie closer together by twice the half height, alike at"
        " all positions; those at 0 V depend on how the load came about."
    ),
    isolates="A dead weight put on and taken off in steps; a reversed approach.",
    source=(
        "OIML R 60, Metrological regulation for load cells; Visintin 1994, Differential Models of"
        " Hysteresis (play and stop)"
    ),
    parameters=(
        EffectParameter(
            name="force_mN",
            meaning="half the height of the loop",
            unit="mN",
            prior_scale=0.05,
            low=0.0,
            high=5.0,
        ),
        EffectParameter(
            name="from_no_load",
            meaning=(
                "0: a run begins in the middle of the loop; 1: at no load; 2: where the run before"
                " ended"
            ),
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=2.0,
            starting_values=(0.0, 1.0, 2.0),
        ),
        EffectParameter(
            name="reach_mN",
            meaning="change of load that turns the loop over; 0: half its height",
            unit="mN",
            prior_scale=0.0,
            low=0.0,
            high=20.0,
            starting_values=(0.0, 0.3, 4.0),
        ),
    ),
    form_error_along=("position", "voltage"),
    by_history=True,
    of_the_rig=True,
)
