"""Free shapes that are still moving."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.data_checks.contract import DataCheck, Suspicion
from model.measurements import Condition, Measurements

USUAL_M = 3e-5  # scatter of a curve's end from picture to picture, where none is stated
TIMES = 8.0  # that it may be exceeded
LEAST_M = 2e-4


@dataclass(frozen=True)
class Swinging(DataCheck):
    """The end of a sheet that nothing touches is elsewhere in each picture."""

    def suspicions(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.suspicions`."""
        free = [c for c in measurements.conditions if c.position_m is None]
        for name in dict.fromkeys(c.configuration for c in free):
            moving = {
                c.voltage_V: _moves_m(c) for c in free if c.configuration == name and _moves_m(c)
            }
            if not moving:
                continue
            volts = max(moving, key=lambda v: moving[v])
            yield Suspicion(
                check=self.name, severity="warn", where="curves.csv, free shapes",
                configurations=(name,), value=1e3 * moving[volts], unit="mm",
                sentence=(
                    f"the end of '{name}' without contact moves by {1e3 * moving[volts]:.2g} mm"
                    f" (RMS, at {volts:+g} V) from picture to picture: it may still swing; wait"
                    " longer before free shapes, or leave them out"
                ),
            )  # fmt: skip


def _moves_m(one: Condition) -> float:
    """Return the RMS distance of the ends about their line in time, m; 0: not unusual."""
    curves = [r.curve for r in one.readings if r.valid and r.curve is not None]
    if len(curves) < 2:
        return 0.0
    ends = np.array([[c.x_m[-1], c.y_m[-1]] for c in curves])
    apart = np.diff(ends, axis=0) / np.sqrt(2.0)  # what goes on evenly is no swing
    found = float(np.sqrt(np.mean(np.sum(apart**2, axis=1))))
    stated = [float(c.sigma_m[-1]) for c in curves if c.sigma_m is not None]
    usual = max(USUAL_M, float(np.mean(stated)) if stated else 0.0)
    return found if found > max(LEAST_M, TIMES * usual) else 0.0


CHECK = Swinging(name="swinging", meaning="the free shapes against each other", order=4)
