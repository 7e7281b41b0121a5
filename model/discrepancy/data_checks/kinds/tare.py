"""The tare of the load cell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import with_forces
from model.measurements import (
    Measurements,
    in_decimals,
    scale_of_measurements,
)

LEAST_N = 1e-3  # smaller ones are a drift of the zero, which diagnose finds as such
LEAST_SHARE = 0.5  # of how far the forces spread


@dataclass(frozen=True)
class Tare(DataCheck):
    """A constant force in all readings of a sheet."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        forces = [r.force_N for c in measurements.conditions for r in c.used()]
        mean_N, spread_N = (float(np.mean(forces)), float(np.std(forces))) if forces else (0.0, 0.0)
        scale = scale_of_measurements(measurements).force
        yield Change(
            where="force_mN",
            apply=lambda m, value: with_forces(m, lambda force_N: force_N - value),
            sentence=lambda names, value, sigma: (
                f"the forces of {names} (force_mN) fit with {in_decimals(1e3 * value, 2)} ±"
                f" {in_decimals(1e3 * sigma, 2)} mN less each: the load cell seems not to"
                " have been tared"
            ),
            values=(0.0, mean_N),
            step=1e-5 * scale,
            stated=0.0,
            least=max(LEAST_N * scale, LEAST_SHARE * spread_N),
            unit="mN",
            factor=1e3,
        )


CHECK = Tare(name="tare", meaning="a constant force in all readings", order=50)
