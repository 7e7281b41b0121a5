"""The polarity of the voltage at one position against that at all others."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import mm
from model.measurements import Measurements

FEWEST_POSITIONS = 3  # of which one can be the odd one out


@dataclass(frozen=True)
class PolarityAtPosition(DataCheck):
    """The leads were exchanged while one position was measured."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        for at_m in _odd_ones(measurements):
            yield _change(at_m)


def _change(at_m: float) -> Change:
    return Change(
        where="voltage_V",
        apply=lambda m, _: _with_other_polarity(m, at_m),
        sentence=lambda names, _value, _sigma: (
            f"the voltages of {names} at {mm(at_m)} (voltage_V) have the other sign than at all"
            " other positions: the leads seem to have been exchanged there"
        ),
        values=(1.0,),
    )


def _odd_ones(measurements: Measurements) -> Iterator[float]:
    """Yield the position at which alone +V moves the force the other way."""
    forces_N = defaultdict[tuple[float, bool], list[float]](list)
    for one in measurements.conditions:
        if one.position_m is not None and one.voltage_V and one.used():
            mean_N = float(np.mean([reading.force_N for reading in one.used()]))
            forces_N[one.position_m, one.voltage_V > 0.0].append(mean_N)
    senses = {
        at_m: float(np.sign(np.mean(some_N) - np.mean(forces_N[at_m, False])))
        for (at_m, is_positive), some_N in forces_N.items()
        if is_positive and (at_m, False) in forces_N
    }
    usual = np.sign(sum(senses.values()))
    odd = [at_m for at_m, sense in senses.items() if sense == -usual]
    if len(odd) == 1 and len(senses) >= FEWEST_POSITIONS:
        yield odd[0]


def _with_other_polarity(measurements: Measurements, at_m: float) -> Measurements:
    conditions = tuple(
        replace(one, voltage_V=-one.voltage_V) if one.position_m == at_m else one
        for one in measurements.conditions
    )
    return replace(measurements, conditions=conditions)


CHECK = PolarityAtPosition(
    name="polarity_at_position",
    meaning="the voltages at one position against those at all others",
    order=32,
)
