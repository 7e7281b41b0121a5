"""Sign and unit of the stated initial curvature."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import with_sheets
from model.measurements import Measurements, SheetGeometry

WAYS = {-1.0: "with the other sign", 1e3: "times 1000", 1e-3: "divided by 1000"}
FULL_TURN_RAD = 2.0 * np.pi


@dataclass(frozen=True)
class InitialCurvature(DataCheck):
    """As it is in sheet.toml."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        (sheet,) = measurements.sheets.values()
        if sheet.initial_curvature is None or not sheet.initial_curvature[1].any():
            return
        turn_rad = float(np.max(np.abs(sheet.initial_curvature[1]))) * sheet.free_length_m
        for factor, way in WAYS.items():
            if _plausible(turn_rad, factor):
                yield _change(factor, way)


def _plausible(turn_rad: float, factor: float) -> bool:
    """Whether a change may be what is wrong with a sheet that turns by so much as it is stated.

    None is curled by more than a turn. One that is not, and seems to be straight, may be heavy.
    """
    if 0.0 < factor < 1.0:
        return turn_rad > FULL_TURN_RAD
    return factor < 0.0 or factor * turn_rad < FULL_TURN_RAD


def _change(factor: float, way: str) -> Change:
    def times(sheet: SheetGeometry, value: float) -> SheetGeometry:
        if sheet.initial_curvature is None:
            return sheet
        s_m, per_m = sheet.initial_curvature
        return replace(sheet, initial_curvature=(s_m, value * per_m))

    return Change(
        where="initial_curvature_per_m in sheet.toml",
        apply=lambda m, value: with_sheets(m, lambda s: times(s, value)),
        sentence=lambda names, _value, _sigma: (
            f"the initial curvature of {names} (initial_curvature_per_m in sheet.toml) fits {way}"
        ),
        values=(factor,),
    )


CHECK = InitialCurvature(
    name="initial_curvature", meaning="the stated initial curvature against the curves", order=80
)
