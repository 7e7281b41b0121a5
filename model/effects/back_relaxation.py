"""The EIBM falls again while the voltage stays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects.interface import Clock, Effect, Knob, Values
from model.measurements import FloatArray

SAMPLE_S = 0.5  # after the edge: where the EIBM of the base model is taken


@dataclass(frozen=True)
class BackRelaxation(Effect):
    """An exponential loss after each edge, relative to the EIBM at the sampling point."""

    def course(self, clock: Clock, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.course`."""
        loss, tau = p["relative_loss_at_sample"], p["time_constant_s"]
        # of what is lost by the sampling point, the share lost by now
        share = np.expm1(-np.maximum(clock.pulse_s, 0.0) / tau) / np.expm1(-SAMPLE_S / tau)
        change = loss * (1.0 - share) / (1.0 - loss)
        change = np.where(clock.voltage_V != 0.0, change, 0.0)
        return change, np.zeros_like(change)


EFFECT = BackRelaxation(
    name="back_relaxation",
    meaning=(
        "Under a voltage that stays the sheet relaxes back: water that came with the ions diffuses"
        " away again, and part of the EIBM is lost."
    ),
    form=(
        "EIBM = EIBM(0.5 s) x (1 - a (1 - exp(-t/tau)))/(1 - a (1 - exp(-0.5 s/tau))), the loss at"
        " the sampling point being a (1 - exp(-0.5 s/tau))"
    ),
    slot="time",
    signature=(
        "Within a pulse the force is at first larger than at the sampling point, and is falling"
        " there; nothing in the means, where it looks like less EIBM."
    ),
    isolates="The force recorded over the whole pulse, or pulses that last longer.",
    source=(
        "Nemat-Nasser and Li 2000, J. Appl. Phys. 87, 3321; Nemat-Nasser 2002, J. Appl. Phys. 92,"
        " 2899"
    ),
    knobs=(
        Knob(
            "relative_loss_at_sample", "share of the EIBM lost 0.5 s after the edge", "", 0.05,
            low=0.0, high=0.8,
        ),
        Knob(
            "time_constant_s", "time in which 63 % of the loss happens", "s", 1.0,
            low=0.05, high=20.0, log=True, tried=(0.3, 1.0, 3.0),
        ),
    ),
    tolerance=("time", "voltage"),
)  # fmt: skip
