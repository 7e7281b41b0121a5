"""The held sheet gives way with time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects.interface import Clock, Effect, Knob, Values
from model.measurements import FloatArray

NEUTRAL_S, FIRST_S = 5.0, 0.1


@dataclass(frozen=True)
class ViscoelasticCreep(Effect):
    """The stiffness changes with the logarithm of the time since the run began."""

    def course(self, clock: Clock, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.course`."""
        decades = np.log10(np.maximum(clock.run_s, FIRST_S) / NEUTRAL_S)
        return np.zeros_like(decades), p["relative_change_per_decade"] * decades


EFFECT = ViscoelasticCreep(
    name="viscoelastic_creep",
    meaning=(
        "Held in one place the polymer relaxes: its stiffness changes by the same share in each"
        " tenfold of the time in the run. Negative is the usual sense: it gives way."
    ),
    form="B = B at 5 s x (1 + c log10(t/5 s)), t since the run began",
    slot="time",
    signature=(
        "In every run anew, at 0 V too, the force changes quickly in the first seconds and ever"
        " more slowly later, in proportion to itself; not in the means."
    ),
    isolates="A long hold at 0 V far from the free position, the first seconds of it recorded.",
    source=(
        "Findley, Lai and Onaran 1976, Creep and Relaxation of Nonlinear Viscoelastic Materials;"
        " Newbury and Leo 2003, J. Intell. Mater. Syst. Struct. 14, 333"
    ),
    knobs=(
        Knob(
            "relative_change_per_decade", "of the stiffness in each tenfold of time", "", 0.03,
            low=-0.4, high=0.4,
        ),
    ),
    tolerance=("time",),
)  # fmt: skip
