"""The unit of the voltages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import DataCheck, Suspicion
from model.measurements import Measurements

APART = 100.0  # ratio of two voltages of a sheet that are hardly both meant
LARGEST_V = 30.0  # no such sheet bears more


@dataclass(frozen=True)
class VoltageUnit(DataCheck):
    """Volts among millivolts."""

    def suspicions(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.suspicions`."""
        driven = [c for c in measurements.conditions if c.voltage_V]
        for name in dict.fromkeys(c.configuration for c in driven):
            sizes = sorted({abs(c.voltage_V) for c in driven if c.configuration == name})
            least, most = sizes[0], sizes[-1]
            if most < APART * least:
                continue
            yield Suspicion(
                check=self.name, severity="stop" if most > LARGEST_V else "warn",
                where="voltage_V", configurations=(name,), value=least / most,
                sentence=(
                    f"the voltages of '{name}' (voltage_V) go from {least:g} V to {most:g} V: some"
                    f" of them seem to be in another unit; {_hint(least, most)}"
                ),
            )  # fmt: skip


def _hint(least: float, most: float) -> str:
    if least >= 1e-3 * most * 0.9 and most > LARGEST_V:
        return f"{most:g} mV would be {1e-3 * most:g} V"
    return "check them"


CHECK = VoltageUnit(name="voltage_unit", meaning="the voltages against each other", order=3)
