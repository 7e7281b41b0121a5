"""Measurements that somebody made in Python: each field is checked before anything is computed.

Those that labrig reads from files have passed other checks, whose sentences name file and line.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, get_args

import numpy as np

from model.measurements.checked_values import (
    is_number,
    require_number,
    require_pair,
    require_truth,
    require_whole_number,
    row,
    shown,
)
from model.measurements.data import (
    Condition,
    Curve,
    Kind,
    Measurements,
    ModelError,
    Reading,
    SheetGeometry,
    TimeSeries,
)

_LENGTHS = (
    "free_length_m", "width_m", "thickness_m", "elongation_m", "arc_radius_m", "arc_origin_rad",
)  # fmt: skip
_KINDS = get_args(Kind)


def require_well_formed(measurements: Measurements) -> None:
    """Raise ModelError, which names the field, for what is not as its class states it."""
    sheets = measurements.sheets
    if not isinstance(sheets, Mapping):
        raise ModelError(
            f"sheets {shown(sheets)}: a dict of SheetGeometry by configuration is needed"
        )
    for name, sheet in sheets.items():
        _sheet(f"sheets[{name!r}]", sheet)
    for index, condition in enumerate(_several("conditions", measurements.conditions)):
        _condition(f"conditions[{index}]", condition, list(sheets))
    for index, series in enumerate(_several("series", measurements.series)):
        name = f"series[{index}]"
        _kind(name, series, TimeSeries)
        _rows(name, series, ("time_s", "drive_V"), ("force_N", "current_A"))


def _sheet(name: str, sheet: Any) -> None:
    _kind(name, sheet, SheetGeometry)
    for each in _LENGTHS:
        require_number(f"{name}.{each}", getattr(sheet, each))
    if sheet.initial_curvature is not None:
        require_pair(f"{name}.initial_curvature", sheet.initial_curvature)


def _condition(name: str, one: Any, sheets: Sequence[str]) -> None:
    _kind(name, one, Condition)
    if one.configuration not in sheets:
        raise ModelError(
            f"{name}.configuration {shown(one.configuration)} is none of the sheets: "
            f"{', '.join(map(str, sheets)) or 'there is none'}"
        )
    if one.position_m is not None:
        require_number(f"{name}.position_m", one.position_m)
    require_number(f"{name}.voltage_V", one.voltage_V)
    _curve(f"{name}.curve", one.curve)
    for index, reading in enumerate(_several(f"{name}.readings", one.readings)):
        _reading(f"{name}.readings[{index}]", reading)


def _reading(name: str, one: Any) -> None:
    _kind(name, one, Reading)
    if one.kind not in _KINDS:
        raise ModelError(f"{name}.kind {shown(one.kind)} is none of {', '.join(_KINDS)}")
    require_truth(f"{name}.valid", one.valid)
    if not is_number(one.force_N):  # one that does not count may be NaN
        raise ModelError(f"{name}.force_N {shown(one.force_N)}: a number is needed")
    require_whole_number(f"{name}.mean_of", one.mean_of, at_least=1)
    if one.sd_N is not None:
        require_number(f"{name}.sd_N", one.sd_N, at_least=0.0)
    _curve(f"{name}.curve", one.curve)


def _curve(name: str, one: Any) -> None:
    if one is None:
        return
    _kind(name, one, Curve)
    further = ("curvature_per_m", "sigma_m", "curvature_sigma_per_m")
    _rows(name, one, ("s_m", "x_m", "y_m"), further)
    if one.sigma_m is not None and not np.all(np.asarray(one.sigma_m) > 0.0):
        raise ModelError(f"{name}.sigma_m: each must be above 0")


def _rows(name: str, one: object, needed: Sequence[str], further: Sequence[str]) -> None:
    """Refuse fields that are no rows of numbers, all of one length."""
    known = [each for each in further if getattr(one, each) is not None]
    lengths = {each: len(row(f"{name}.{each}", getattr(one, each))) for each in (*needed, *known)}
    first = lengths[needed[0]]
    for each, length in lengths.items():
        if length != first:
            raise ModelError(f"{name}: {needed[0]} has {first} values, {each} has {length}")


def _kind(name: str, one: object, kind: type) -> None:
    if not isinstance(one, kind):
        raise ModelError(f"{name} {shown(one)}: a model.{kind.__name__} is needed")


def _several(name: str, given: object) -> Iterable[object]:
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise ModelError(f"{name} {shown(given)}: a tuple is needed")
    return given
