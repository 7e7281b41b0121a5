"""The EIBM falls again while the voltage stays."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._memory import SPREAD, lagging, spread_about
from model.effects.interface import AcquisitionTimes, Effect, EffectParameter, Values
from model.measurements import FloatArray
from model.measurements.pulse_train import SAMPLE_S

# the EIBM of the base model is that at the sampling point, in a pulse far from the first
AT_SAMPLE, LATE = np.array(SAMPLE_S), 1e3


@dataclass(frozen=True)
class BackRelaxation(Effect):
    """A loss after each edge, relative to the EIBM at the sampling point.

    What follows the EIBM slowly is taken from it; it may begin anew with each pulse, or remember
    the one before.
    """

    def course(self, clock: AcquisitionTimes, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.course`."""
        loss = p["relative_loss_at_sample"]
        times = spread_about(p["time_constant_s"], p[SPREAD.name])
        before = np.minimum(clock.opposite, 0.0)
        settled = np.where(before < 0.0, before, np.min(before, initial=0.0))
        # of what a sheet at rest has lost by the sampling point, what is lost by now
        whole = float(np.mean(-np.expm1(-SAMPLE_S / times)))
        late = replace(clock, pulse=np.full_like(clock.pulse, LATE), pulse_s=AT_SAMPLE)
        now, sampled = (
            np.mean([lagging(c, float(tau), p["remembers"] * b) for tau in times], axis=0) / whole
            for c, b in ((clock, before), (late, settled))
        )
        change = loss * (sampled - now) / (1.0 - loss * sampled)
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
        " the sampling point being a (1 - exp(-0.5 s/tau)); of each pulse anew, or as a lag that"
        " remembers the pulses before; with one time constant, or several"
    ),
    location="time",
    signature=(
        "Within a pulse the force is at first larger than at the sampling point, and is falling"
        " there; nothing in the means, where it looks like less EIBM."
    ),
    isolates="The force recorded over the whole pulse, or pulses that last longer.",
    source=(
        "Nemat-Nasser and Li 2000, J. Appl. Phys. 87, 3321; Nemat-Nasser 2002, J. Appl. Phys. 92,"
        " 2899"
    ),
    parameters=(
        EffectParameter(
            name="relative_loss_at_sample",
            meaning="share of the EIBM lost 0.5 s after the edge",
            unit="",
            prior_scale=0.05,
            low=0.0,
            high=0.8,
        ),
        EffectParameter(
            name="time_constant_s",
            meaning="time in which 63 % of the loss happens",
            unit="s",
            prior_scale=1.0,
            low=0.05,
            high=20.0,
            log=True,
            starting_values=(0.3, 1.0, 3.0),
        ),
        EffectParameter(
            name="remembers",
            meaning="0: each pulse begins anew; 1: what it lost is lost to the next",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=1.0,
            starting_values=(0.0, 1.0),
        ),
        SPREAD,
    ),
    explained_by_dynamics=True,
    form_error_along=("time", "voltage"),
)
