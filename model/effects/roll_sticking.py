"""From a position on the sheet sticks between the rolls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._loop import hung
from model.effects._values import MILLI
from model.effects.interface import Effect, EffectParameter, LoadCellInput, Values
from model.measurements import FloatArray

_SAME_M = 1e-6
FROM_NO_LOAD, WITH_THE_FORCE, ONE_WAY, OTHER_WAY = 1, 2, 3, 4
TURNS_N = 5e-5  # within which a force changes its sign


@dataclass(frozen=True)
class RollSticking(Effect):
    """Beyond a position a change of force comes through only when it has pulled the sheet loose.

    Or, more simply, the rolls hold the sheet with a force that the load cell sees with the force's
    own sign, or always one way, whatever came before.
    """

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray:
        """See `Effect.force`."""
        ahead = self._kept_back_N(weighed, p["force_mN"] * MILLI, round(p["kind"]))
        sticks = weighed.position_m >= p["from_position_mm"] * MILLI - _SAME_M
        return np.where(sticks & (weighed.touching > 0.0), -ahead, 0.0)

    def _kept_back_N(self, weighed: LoadCellInput, force_N: float, kind: int) -> FloatArray:
        if kind == WITH_THE_FORCE:
            return force_N * np.tanh(weighed.force_N / (TURNS_N * weighed.force_scale))
        if kind in (ONE_WAY, OTHER_WAY):
            return np.full_like(weighed.force_N, -force_N if kind == ONE_WAY else force_N)
        return hung(weighed.force_N, weighed.position_m, force_N, from_no_load=kind == FROM_NO_LOAD)


EFFECT = RollSticking(
    name="roll_sticking",
    meaning=(
        "From some position on the sheet is stuck between the rolls: it slides only when the change"
        " of force exceeds what holds it."
    ),
    form=(
        "F measured = F - c sign(last change of F) from a position on, once F has changed by more"
        " than c; or F - c sign(F), F + c or F - c"
    ),
    location="position",
    signature=(
        "At the far positions only, the voltages' forces lie closer together than they should, by"
        " twice the force that sticks; those at 0 V are right."
    ),
    isolates="The sheet watched in the rolls; a tap on the rig; far positions approached again.",
    source="the paper, section 3.3: at 30 mm the sheet systematically got stuck between the rolls",
    parameters=(
        EffectParameter(
            name="force_mN",
            meaning="change of force that it takes to get it loose",
            unit="mN",
            prior_scale=0.2,
            low=0.0,
            high=5.0,
        ),
        EffectParameter(
            name="from_position_mm",
            meaning="the first position at which it sticks",
            unit="mm",
            prior_scale=25.0,
            neutral=np.inf,
            starting_values=(5.0, 10.0, 15.0, 20.0, 25.0, 30.0),
        ),
        EffectParameter(
            name="kind",
            meaning="0: a loop, begun in its middle by each run; 1: begun at no load; 2: no loop,"
            " held against the force whatever came before; 3: pulled one way; 4: the other way",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=4.0,
            starting_values=(0.0, 1.0, 2.0, 3.0, 4.0),
        ),
    ),
    form_error_along=("position", "voltage", "polarity"),
    by_configuration=True,
    by_history=True,
)
