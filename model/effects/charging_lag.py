"""The EIBM follows the voltage too slowly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects.interface import Clock, Effect, Knob, Values
from model.measurements import FloatArray


@dataclass(frozen=True)
class ChargingLag(Effect):
    """From what it was before the edge the EIBM goes exponentially to its settled value."""

    def course(self, clock: Clock, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.course`."""
        missing = np.zeros_like(clock.pulse_s)
        if p["time_constant_s"] > 0.0:
            left = np.exp(-np.maximum(clock.pulse_s, 0.0) / p["time_constant_s"])
            missing = np.where(clock.voltage_V != 0.0, (clock.opposite - 1.0) * left, 0.0)
        return missing, np.zeros_like(missing)


EFFECT = ChargingLag(
    name="charging_lag",
    meaning=(
        "The sheet is a slow capacitor: 0.5 s after an edge of the voltage its EIBM has not"
        " arrived yet."
    ),
    form="EIBM = settled x (1 - (1 - q) exp(-t/tau)), q = EIBM before the edge over settled",
    slot="time",
    signature=(
        "Within a pulse the force still goes its way at the sampling point; the first pulse, which"
        " begins from 0 V, lacks half as much. Nothing in the means, where it looks like less EIBM."
    ),
    isolates="The force recorded over the whole pulse, or pulses that last longer.",
    source=(
        "Bao, Bar-Cohen and Lih 2002, Proc. SPIE 4695, 220 (IPMC as resistors and capacitors);"
        " Shahinpoor and Kim 2000, Smart Mater. Struct. 9, 543"
    ),
    knobs=(
        Knob(
            "time_constant_s", "time in which the EIBM does 63 % of its way", "s", 0.12,
            low=0.003, high=3.0, log=True, tried=(0.05, 0.08, 0.12, 0.18, 0.27, 0.4),
        ),
    ),
    tolerance=("time", "voltage"),
)  # fmt: skip
