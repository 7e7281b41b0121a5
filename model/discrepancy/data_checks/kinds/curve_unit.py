"""The unit of the curves, by their lengths."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.data_checks.contract import DataCheck, Suspicion
from model.discrepancy.data_checks.kinds._data import curves_of, lengths_m
from model.discrepancy.thresholds import LONGEST_CURVE_RATIO, SHORTEST_CURVE_RATIO
from model.measurements import Curve, Measurements, SheetGeometry

UNITS = {1e3: "metres", 10.0: "cm", 1e-3: "µm"}
CONTRADICTION = 0.1  # relative, of the s of a curve's end and its length along x and y


@dataclass(frozen=True)
class CurveUnit(DataCheck):
    """Metres, pixels."""

    def suspicions(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.suspicions`."""
        for name, sheet in measurements.sheets.items():
            own = [c for c in measurements.conditions if c.configuration == name]
            curves = curves_of(Measurements(sheets={}, conditions=tuple(own)))
            if curves:
                yield from _of(self.name, sheet, curves)


def _of(check: str, sheet: SheetGeometry, curves: list[Curve]) -> Iterator[Suspicion]:
    whole_m, long_m = sheet.free_length_m + sheet.elongation_m, lengths_m(curves)
    name, end_m = sheet.configuration, np.array([c.s_m[-1] for c in curves])
    low, high = SHORTEST_CURVE_RATIO * sheet.free_length_m, LONGEST_CURVE_RATIO * whole_m
    wrong = (long_m < low) | (long_m > high)
    contradicts = np.abs(long_m / np.maximum(end_m, 1e-12) - 1.0) > CONTRADICTION
    many = "" if wrong.all() else f"{int(wrong.sum())} of the {len(curves)} "
    if wrong.any():
        typical_m = float(np.median(long_m[wrong]))
        factor = whole_m / max(typical_m, 1e-12)
        yield Suspicion(
            check=check, severity="stop", where="x_mm and y_mm of curves.csv",
            configurations=(name,), value=factor,
            sentence=(
                f"{many}curves of '{name}' (x_mm, y_mm) are {1e3 * typical_m:.3g} mm long, the"
                f" sheet {1e3 * whole_m:.3g} mm: {_unit(factor)}"
            ),
        )  # fmt: skip
    elif contradicts.any():
        typical = float(np.median(end_m[contradicts] / long_m[contradicts]))
        yield Suspicion(
            check=check, severity="stop", where="s_mm of curves.csv", configurations=(name,),
            value=1.0 / typical,
            sentence=(
                f"s_mm of {int(contradicts.sum())} of the {len(curves)} curves of '{name}' is"
                f" {typical:.3g} times their length along x_mm and y_mm, which must be equal"
            ),
        )  # fmt: skip


def _unit(factor: float) -> str:
    for of_ten, unit in UNITS.items():
        if abs(np.log(factor / of_ten)) < np.log(1.0 / 0.6):
            return f"multiplied by {of_ten:g} they fit, so they seem to be in {unit}"
    return (
        f"they fit with {1.0 / factor:.3g} units to the mm, so they may be in pixels; calibrate the"
        " camera, or divide by that"
    )


CHECK = CurveUnit(name="curve_unit", meaning="the lengths of the curves, to a factor", order=1)
