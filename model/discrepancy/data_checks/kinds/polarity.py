"""The polarity of the voltage in the table of forces against that in the table of curves."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.measurements import Condition, Measurements


@dataclass(frozen=True)
class Polarity(DataCheck):
    """Curves at +V are those at -V."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        voltages = {c.voltage_V for c in measurements.conditions if c.curve is not None}
        if any(v and -v in voltages for v in voltages):
            yield Change(
                where="voltage_V",
                apply=lambda m, _: _exchanged(m),
                sentence=lambda names, _value, _sigma: (
                    f"forces and curves of {names} contradict each other unless the polarities"
                    " (voltage_V) are exchanged in one of them: either the curves at +V belong to"
                    " -V, or the forces"
                ),
                values=(-1.0,),
            )


def _place(one: Condition, sign: float) -> tuple[object, ...]:
    at = one.configuration, one.position_m, one.mounting, one.run, one.approach, one.tilt_rad
    return *at, sign * one.voltage_V


def _exchanged(measurements: Measurements) -> Measurements:
    """With the curves of opposite voltages exchanged."""
    curves = {_place(c, 1.0): c.curve for c in measurements.conditions}
    conditions = [
        replace(c, curve=curves.get(_place(c, -1.0), c.curve)) if c.voltage_V else c
        for c in measurements.conditions
    ]
    return replace(measurements, conditions=tuple(conditions))


CHECK = Polarity(
    name="polarity", meaning="the voltages of the forces against the curves'", order=30
)
