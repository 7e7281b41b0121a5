"""The EIBM follows the voltage too slowly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.effects._memory import before_edge
from model.effects.interface import AcquisitionTimes, Effect, EffectParameter, Values
from model.measurements import FloatArray


@dataclass(frozen=True)
class ChargingLag(Effect):
    """From what it was before the edge the EIBM goes exponentially to its settled value.

    It follows the voltage at the sheet, which takes its known time to rise: two lags in a row, of
    which the base model has the known one. The slow one has not forgotten the pulse before.
    """

    def course(self, clock: AcquisitionTimes, p: Values) -> tuple[FloatArray, FloatArray]:
        """See `Effect.course`."""
        missing = np.zeros_like(clock.pulse_s)
        tau = p["time_constant_s"]
        if tau > 0.0:
            t = np.maximum(clock.pulse_s, 0.0)
            further = before_edge(clock, tau, clock.opposite) - clock.opposite
            further = np.where(clock.opposite < 0.0, p["remembers"] * further, 0.0)
            missing = (clock.opposite - 1.0) * _left(t, tau, clock.rise_s)
            missing += further * np.exp(-t / tau)
            missing = np.where(clock.voltage_V != 0.0, p["slow_share"] * missing, 0.0)
        return missing, np.zeros_like(missing)


def _left(t_s: FloatArray, tau_s: float, rise_s: FloatArray | float) -> FloatArray:
    """Return what is left to go after both lags, less what would be after the known one alone.

    tau (exp(-t/tau) - exp(-t/rise))/(tau - rise), written so that both may be the same.
    """
    rise = np.maximum(rise_s, 1e-9)
    faster = 1.0 / rise - 1.0 / tau_s
    faster = np.where(np.abs(faster) * tau_s < 1e-9, 1e-9 / tau_s, faster)
    left: FloatArray = np.exp(-t_s / tau_s) * -np.expm1(-t_s * faster) / (rise * faster)
    return left


EFFECT = ChargingLag(
    name="charging_lag",
    meaning=(
        "The sheet is a slow capacitor: 0.5 s after an edge of the voltage its EIBM has not"
        " arrived yet."
    ),
    form=(
        "EIBM = settled x (1 - (1 - q) exp(-t/tau)), q = EIBM before the edge over settled; behind"
        " the known rise of the voltage, as two lags in a row; all of it, or a part"
    ),
    location="time",
    signature=(
        "Within a pulse the force still goes its way at the sampling point; the first pulse, which"
        " begins from 0 V, lacks half as much. Nothing in the means, where it looks like less EIBM."
    ),
    isolates="The force recorded over the whole pulse, or pulses that last longer.",
    source=(
        "Bao, Bar-Cohen and Lih 2002, Proc. SPIE 4695, 220 (IPMC as resistors and capacitors);"
        " Shahinpoor and Kim 2000, Smart Mater. Struct. 9, 543"
    ),
    parameters=(
        EffectParameter(
            name="time_constant_s",
            meaning="time in which the EIBM does 63 % of its way",
            unit="s",
            prior_scale=0.12,
            low=0.003,
            high=3.0,
            log=True,
            starting_values=(0.015, 0.03, 0.05, 0.08, 0.12, 0.18, 0.27, 0.4),
        ),
        EffectParameter(
            name="slow_share",
            meaning="of the EIBM, that comes so; the rest comes with the voltage",
            unit="",
            prior_scale=1.0,
            low=0.05,
            high=1.0,
            log=True,
            starting_values=(1.0,),
        ),
        EffectParameter(
            name="remembers",
            meaning="1: a pulse begins where the one before came to; 0: where it would have"
            " settled",
            unit="",
            prior_scale=1.0,
            low=0.0,
            high=1.0,
            starting_values=(1.0, 0.0),
        ),
    ),
    explained_by_dynamics=True,
    form_error_along=("time", "voltage"),
)
