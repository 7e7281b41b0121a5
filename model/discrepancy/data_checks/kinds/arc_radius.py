"""The radius of the arc on which the rolls stand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import mm, with_sheets
from model.measurements import Measurements

LEAST_SHARE = 0.03  # of the radius: less is how well people measure it
RANGE = 0.3, 3.0  # of what is stated


@dataclass(frozen=True)
class ArcRadius(DataCheck):
    """Another radius."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        (sheet,) = measurements.sheets.values()
        stated = sheet.arc_radius_m
        yield Change(
            where="radius_mm of [arc] in sheet.toml",
            apply=lambda m, value: with_sheets(m, lambda s: replace(s, arc_radius_m=value)),
            sentence=lambda names, value, sigma: (
                f"the radius of the arc (radius_mm of [arc] in sheet.toml) is {mm(stated)};"
                f" forces and curves of {names} say {mm(value, sigma)}"
            ),
            values=(stated,),
            step=1e-3 * stated,
            stated=stated,
            least=LEAST_SHARE * stated,
            bounds=(RANGE[0] * stated, RANGE[1] * stated),
            unit="mm",
            factor=1e3,
            of_rig=True,
        )


CHECK = ArcRadius(name="arc_radius", meaning="the arc's radius against forces and curves", order=60)
