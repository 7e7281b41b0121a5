"""The first pulses of a run differ from the later ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects.interface import AcquisitionTimes, Effect, EffectParameter, Values
from model.measurements import FloatArray
from model.measurements.pulse_train import PULSE_S, SAMPLE_S


@dataclass(frozen=True)
class FirstPulseTransient(Effect):
    """Pulse k = 0, 1, ... lacks a r^k of the EIBM at its sampling point, and less as it goes on."""

    def course(self, clock: AcquisitionTimes, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.course`."""
        k = clock.pulse + (clock.pulse_s - SAMPLE_S) / PULSE_S
        left = p["ratio"] ** np.maximum(k, -1.0)
        missing = np.where(clock.pulse >= 0.0, -p["relative_deficit"] * left, 0.0)
        return missing, np.zeros_like(missing)


EFFECT = FirstPulseTransient(
    name="first_pulse_transient",
    meaning=(
        "The EIBM of the first pulses of a run falls short of the later ones', while the water in"
        " the sheet is still evenly distributed."
    ),
    form=(
        "EIBM = settled x (1 - a r^k), k = 0, 1, ... at the sampling points of the pulses and on by"
        " 1 in 0.6 s between them"
    ),
    location="time",
    signature=(
        "In every run anew, what the voltage does grows from pulse to pulse and then stays; not at"
        " 0 V, and hardly in the means, of which the first two pulses are left out."
    ),
    isolates="The discarded pulses, or a run begun again without a rest.",
    source="the paper, section 3.2: the first two pulses are neglected",
    parameters=(
        # a first pulse that exceeds the others is what a lag makes of it, which begins from 0 V
        EffectParameter(
            name="relative_deficit",
            meaning="of the EIBM in the first pulse",
            unit="",
            prior_scale=0.15,
            low=-1.0,
            high=1.0,
            expected_sign=1.0,
        ),
        EffectParameter(
            name="ratio",
            meaning="of each pulse's deficit to that before",
            unit="",
            prior_scale=0.5,
            low=0.05,
            high=0.75,
            log=True,
            starting_values=(0.3, 0.5, 0.7),
        ),
    ),
    form_error_along=("time", "voltage"),
)
