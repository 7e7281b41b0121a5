"""The held sheet gives way with time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import finite
from model.effects.interface import Beam, Clock, Effect, Held, Knob, Values
from model.measurements import FloatArray

NEUTRAL_S, FIRST_S = 5.0, 0.1


@dataclass(frozen=True)
class ViscoelasticCreep(Effect):
    """The stiffness changes with the logarithm of the time since the run began.

    What relaxes is the stress of a strain that stays. Taken strictly (`memory` 1) that is the
    strain at 0 V, in which the sheet is held all the time; the pulses come and go too quickly.
    Taken loosely (`memory` 0) the stiffness as a whole goes down.
    """

    def beam(self, beam: Beam, held: Held, p: Values) -> Beam:
        """See `Effect.beam`."""
        if p["memory"] < 0.5:
            return beam
        bent = -finite(held.normal_N)[:, None] * finite(held.lever) / beam.stiffness[:, None]
        stays = np.zeros_like(bent)
        for k, at in enumerate(beam.stated_m):
            same = (beam.voltage_V == 0.0) & (np.abs(beam.stated_m - at) < 1e-9)
            if same.any():
                stays[k] = bent[same].mean(axis=0)
        return replace(beam, rest=beam.rest - p["relative_change_per_decade"] * stays)

    def course(self, clock: Clock, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.course`."""
        decades = np.log10(np.maximum(clock.run_s, FIRST_S) / NEUTRAL_S)
        if p["memory"] > 0.5:
            decades = np.where(clock.voltage_V == 0.0, decades, 0.0)
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
        Knob(
            "memory", "1: only the strain that stays relaxes; 0: the stiffness as a whole", "",
            0.0, 0.0, 1.0, tried=(0.0, 1.0),
        ),
    ),
    tolerance=("time", "voltage"),
)  # fmt: skip
