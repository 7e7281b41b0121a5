"""The readings that a prediction stands for: those of the paper's pulse train, mid-session.

A model whose effects depend on time or on the order of the readings says what the mean of a
condition's kept readings would be in such a run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from model.effects.interface import AcquisitionTimes
from model.measurements import FloatArray
from model.measurements.pulse_train import DISCARDED, PULSE_S, PULSES, SAMPLE_S, ZEROS


@dataclass(frozen=True)
class TypicalRun:
    """Readings in the order of time: at 0 V, then pulses of `first_V` and `second_V` in turn."""

    clock: AcquisitionTimes
    kept: npt.NDArray[np.bool_]

    def at(self, voltage_V: float) -> npt.NDArray[np.bool_]:
        """Return which kept readings belong to a voltage."""
        result: npt.NDArray[np.bool_] = self.kept & (self.clock.voltage_V == voltage_V)
        return result


def typical_run(
    voltage_V: float, other_V: float, rise_s: float = 0.0, position_m: float = np.nan,
    ratio: float = 1.0,
) -> TypicalRun:  # fmt: skip
    """Return the run of a condition at `voltage_V`; with 0 V first, only its beginning is kept.

    Its times are those of data (`data.acquisition_times`), to which effects were fitted. It begins
    with the positive voltage, as the paper's. `ratio`: |EIBM(-)/EIBM(+)|.
    """
    first_V, second_V = voltage_V, other_V
    if first_V < 0.0 < second_V:
        first_V, second_V = second_V, first_V
    pulse = np.concatenate([np.full(ZEROS, -1.0), np.arange(PULSES, dtype=float)])
    turn = np.arange(PULSES) % 2
    pulses_V = np.where(turn == 0, first_V, second_V)
    voltage = np.concatenate([np.zeros(ZEROS), pulses_V])
    run_s: FloatArray = PULSE_S * np.arange(len(pulse), dtype=float) + SAMPLE_S
    # 0 before the first pulse; later the other polarity, or the rest that stands for it
    behind = np.where(voltage > 0.0, -ratio, -1.0 / ratio) if first_V * second_V < 0.0 else 0.0
    before = np.where(pulse > 0.0, behind, np.where(pulse < 0.0, 1.0, 0.0))
    clock = AcquisitionTimes(
        voltage_V=voltage, pulse_s=np.full(len(pulse), SAMPLE_S), pulse=pulse, run_s=run_s,
        session=np.full(len(pulse), 0.5), wetted_s=run_s,
        driven_s=PULSE_S * np.maximum(pulse, 0.0), opposite=np.asarray(before, dtype=float),
        rise_s=rise_s, position_m=position_m,
    )  # fmt: skip
    return TypicalRun(clock, (pulse < 0.0) | ((pulse >= DISCARDED) & (voltage != 0.0)))


def kept_readings(
    runs: Sequence[TypicalRun], voltages_V: Sequence[float]
) -> tuple[AcquisitionTimes, npt.NDArray[np.int64]]:
    """Return the kept readings of all conditions in order, and each one's condition index: (n,)."""
    use = [run.at(volts) for run, volts in zip(runs, voltages_V, strict=True)]
    clock = AcquisitionTimes.joined([run.clock.of(u) for run, u in zip(runs, use, strict=True)])
    return clock, np.repeat(np.arange(len(use)), [int(np.sum(u)) for u in use])


def mean_over(values: FloatArray, use: npt.NDArray[np.bool_]) -> float:
    """Mean of the readings in use; 0 where there are none."""
    return float(np.mean(values[use])) if np.any(use) else 0.0
