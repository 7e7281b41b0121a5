"""Sign and unit of the stated initial curvature."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from model.discrepancy.data_checks.contract import Change, DataCheck
from model.discrepancy.data_checks.kinds._data import with_sheets
from model.measurements import Measurements, SheetGeometry

WAYS = {-1.0: "with the other sign", 1e3: "times 1000", 1e-3: "divided by 1000"}


@dataclass(frozen=True)
class InitialCurvature(DataCheck):
    """As it is in sheet.toml."""

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        (sheet,) = measurements.sheets.values()
        if sheet.initial_curvature is not None and sheet.initial_curvature[1].any():
            for factor, way in WAYS.items():
                yield _change(factor, way)


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
