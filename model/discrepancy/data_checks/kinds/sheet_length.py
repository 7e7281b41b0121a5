"""The length of the sheet with its elongation, by where the curves end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.data_checks.contract import DataCheck, Suspicion
from model.discrepancy.data_checks.kinds._data import curves_of, lengths_m, mm
from model.discrepancy.thresholds import LONGEST_CURVE_RATIO, SHORTEST_CURVE_RATIO
from model.measurements import Measurements, SheetGeometry

FEWEST = 4  # curves
SAME = 0.01  # relative scatter of the curves' ends: they end where the sheet does
WRONG = 0.04  # relative, from which on the length is suspicious


@dataclass(frozen=True)
class SheetLength(DataCheck):
    """All curves end at the same place, which is not the sheet's end."""

    def suspicions(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.suspicions`."""
        for name, sheet in measurements.sheets.items():
            own = [c for c in measurements.conditions if c.configuration == name]
            long_m = lengths_m(curves_of(Measurements(sheets={}, conditions=tuple(own))))
            whole_m = sheet.free_length_m + sheet.elongation_m
            if len(long_m) < FEWEST:
                continue
            middle_m = float(np.median(long_m))
            spread_m = float(np.std(long_m))
            possible = SHORTEST_CURVE_RATIO < middle_m / whole_m < LONGEST_CURVE_RATIO
            wrong = abs(middle_m / whole_m - 1.0) > WRONG and spread_m < SAME * middle_m
            if possible and wrong:
                yield _suspicion(self.name, sheet, middle_m, spread_m)


def _suspicion(check: str, sheet: SheetGeometry, length_m: float, spread_m: float) -> Suspicion:
    name, whole_m = sheet.configuration, sheet.free_length_m + sheet.elongation_m
    key, value_m = "free_length_mm", length_m
    stated = f"the free length of '{name}' ({key} in sheet.toml) is {mm(whole_m)}"
    fits = ""
    if sheet.elongation_m:
        key, value_m = "elongation_mm", length_m - sheet.free_length_m
        stated = (
            f"free length and elongation of '{name}' (free_length_mm, {key} in sheet.toml) are"
            f" {mm(whole_m)} together"
        )
        fits = f", so that an elongation of {mm(value_m)} would fit"
    return Suspicion(
        check=check, severity="warn", where=f"{key} of [{name}] in sheet.toml",
        configurations=(name,), value=1e3 * value_m, sigma=1e3 * spread_m, unit="mm",
        sentence=f"{stated}; all curves end at {mm(length_m, spread_m)}{fits}",
    )  # fmt: skip


CHECK = SheetLength(name="sheet_length", meaning="the sheet's length against the curves'", order=2)
