"""The unit of the positions on the arc."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import mm, positions_m, with_positions
from model.measurements import Measurements

FACTORS = {1e3: "metres", 10.0: "cm", 0.1: "tenths of a mm", 1e-3: "µm"}
SHORTEST, LONGEST = 0.03, 2.0  # of a plausible range of positions, in radii of the arc


@dataclass(frozen=True)
class PositionUnit(DataCheck):
    """Another power of ten."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        places = positions_m(measurements)
        (sheet,) = measurements.sheets.values()
        farthest = max((abs(p) for p in places), default=0.0)
        for factor, unit in FACTORS.items():
            if SHORTEST < factor * farthest / sheet.arc_radius_m < LONGEST:
                yield _change(factor, unit, farthest)


def _change(factor: float, unit: str, farthest_m: float) -> Change:
    def sentence(names: str, _value: float, _sigma: float) -> str:
        return (
            f"the positions of {names} (position_mm) reach {mm(farthest_m)}; multiplied by"
            f" {factor:g} they fit, so they seem to be in {unit}"
        )

    return Change(
        where="position_mm",
        apply=lambda m, value: with_positions(m, lambda p: p * value),
        sentence=sentence,
        values=(factor,),
    )


CHECK = PositionUnit(
    name="position_unit", meaning="the unit of the positions against forces and curves", order=10
)
