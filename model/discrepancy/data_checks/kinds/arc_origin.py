"""Where position 0 is on the arc."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import with_positions
from model.measurements import Measurements

LEAST_SHARE = 0.1  # of the radius: less is a position error, which diagnose finds as such


@dataclass(frozen=True)
class ArcOrigin(DataCheck):
    """All positions are off by the same."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        (sheet,) = measurements.sheets.values()
        R = sheet.arc_radius_m
        yield Change(
            where="origin_deg of [arc] in sheet.toml",
            apply=lambda m, value: with_positions(m, lambda p: p + value),
            sentence=lambda names, value, sigma: (
                f"the positions of {names} (position_mm) fit when {1e3 * value:.1f} ±"
                f" {1e3 * sigma:.1f} mm are added to each, or origin_deg of [arc] in sheet.toml is"
                f" {np.degrees(sheet.arc_origin_rad + value / R):.1f} instead of"
                f" {np.degrees(sheet.arc_origin_rad):g}"
            ),
            values=(0.0,),
            step=1e-3 * R,
            stated=0.0,
            least=LEAST_SHARE * R,
            bounds=(-1.5 * R, 1.5 * R),
            unit="mm",
            factor=1e3,
        )


CHECK = ArcOrigin(name="arc_origin", meaning="where position 0 is, against the curves", order=65)
