"""Fewer voltages where a waveform was read at dozens: each has an EIBM of its own to be searched.

A search takes the square and more of the voltages of a run; their neighbours tell it nothing new.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.measurements import Measurements

MOST_VOLTAGES = 12  # of a configuration, beside 0 V
LEAST_POSITIONS = 2  # fewer of each voltage: they were measured rather than set, and none can go


def with_few_voltages(measurements: Measurements) -> tuple[Measurements, tuple[str, ...]]:
    """Return measurements at no more voltages than can be searched, and what was left out.

    The largest of either sign stay, and of the others as many in even steps of their order.
    """
    told = list[str]()
    gone = set[tuple[str, float]]()
    for name in measurements.sheets:
        driven = [c for c in measurements.conditions if c.configuration == name and c.voltage_V]
        volts = sorted({c.voltage_V for c in driven})
        if len(volts) <= MOST_VOLTAGES or len(driven) < LEAST_POSITIONS * len(volts):
            continue
        kept = {volts[i] for i in np.linspace(0, len(volts) - 1, MOST_VOLTAGES).round().astype(int)}
        gone |= {(name, voltage_V) for voltage_V in volts if voltage_V not in kept}
        told.append(
            f"'{name}' was measured at {len(volts)} voltages; the search takes {len(kept)} of them,"
            " from the smallest to the largest"
        )
    if not gone:
        return measurements, ()
    conditions = [c for c in measurements.conditions if (c.configuration, c.voltage_V) not in gone]
    return replace(measurements, conditions=tuple(conditions)), tuple(told)
