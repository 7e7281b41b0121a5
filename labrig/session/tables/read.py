"""CSV files into measurements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, NamedTuple, cast

import numpy as np

from drivers.interfaces import FloatArray
from labrig.errors import BadInputError
from labrig.plausibility import unit_warnings
from labrig.session.tables import columns
from labrig.session.tables.csv_rows import CsvRow, integer, one_of, read_rows, truth
from labrig.session.tables.curve_points import CurvePoints
from labrig.session.tables.decimals import from_degrees, from_milli, from_plain, milli
from model.measurements import Condition, Kind, Measurements, Reading, SheetGeometry, TimeSeries

NUMBER = "a number"
WHOLE = "a whole number from 0"
_UNSAID = (
    "{} does not say of which run some of its curves are: the first curve is taken for that of the"
    " first run. The column run or approach would say it."
)


class _Key(NamedTuple):
    """What tells one condition from another."""

    configuration: str
    position_m: float | None
    voltage_V: float
    mounting: int
    approach: str
    run: int


class _Conditions(dict["_Key", "_Gathered"]):
    """Conditions while their rows come in, also by all that any row of theirs says."""

    def __init__(self) -> None:
        super().__init__()
        self._alike: dict[tuple[str, float | None, float, int], list[_Key]] = {}

    def of(self, key: _Key, tilt_rad: float) -> _Gathered:
        """Return the condition of a key, a new one where there is none."""
        if key not in self:
            self[key] = _Gathered(tilt_rad)
            self._alike.setdefault(key[:4], []).append(key)
        return self[key]

    def alike(self, key: _Key) -> list[_Key]:
        """Return the keys that differ from one in approach and run at most."""
        return self._alike.get(key[:4], [])


@dataclass
class _Gathered:
    """A condition while its rows come in."""

    tilt_rad: float
    readings: dict[int, Reading] = field(default_factory=dict)
    curves: dict[int | None, CurvePoints] = field(default_factory=dict)


def read_tables(
    sheet: Mapping[str, SheetGeometry],
    forces: Path | str | None,
    curves: Path | str | None = None,
    signals: Path | str | None = None,
) -> Measurements:
    """Measurements from CSV files: forces, curves or both.

    Raises BadInputError naming file, line and column.
    """
    forces, curves, signals = (None if p is None else Path(p) for p in (forces, curves, signals))
    source = forces or curves
    if source is None:
        raise BadInputError("there is neither a table of forces nor one of curves.")
    gathered = _Conditions()
    if forces is not None:
        for row in read_rows(forces, columns.FORCES, columns.FORCES_OPTIONAL, columns.CHANNEL):
            _add_force(gathered, row, sheet)
    unsaid = False
    if curves is not None:
        for row in read_rows(curves, columns.CURVES, columns.CURVES_OPTIONAL):
            unsaid |= _add_point(gathered, row, sheet)
    if forces is not None and not any(each.readings for each in gathered.values()):
        raise BadInputError(f"{forces}: holds no readings.")
    without = _without_force(gathered) if forces is not None else ()
    found = Measurements(
        sheets=dict(sheet),
        conditions=tuple(_condition(key, each) for key, each in gathered.items()),
        series=_series(signals, sheet) if signals is not None else (),
        source=source.name,
        warnings=(*without, *([_UNSAID.format(curves)] if unsaid else [])),
    )
    return replace(found, warnings=(*found.warnings, *unit_warnings(found)))


# -------------------------------------------------------------------------------------- conditions


def _configuration(row: CsvRow, sheet: Mapping[str, SheetGeometry]) -> str:
    name = row.get("configuration", str, "a table of sheet.toml")
    if name not in sheet:
        raise row.fault(f"configuration {name!r} is no table of the sheet, {', '.join(sheet)}")
    return name


def _key(row: CsvRow, sheet: Mapping[str, SheetGeometry]) -> _Key:
    return _Key(
        configuration=_configuration(row, sheet),
        position_m=row.optional("position_mm", from_milli, NUMBER, None),
        voltage_V=row.get("voltage_V", from_plain, NUMBER) + 0.0,  # -0 V is 0 V
        mounting=row.optional("mounting", integer, WHOLE, 0),
        approach=row.optional("approach", one_of(*columns.APPROACHES), "up or down", ""),
        run=row.optional("run", integer, WHOLE, 0),
    )


def _gathered(gathered: _Conditions, key: _Key, row: CsvRow) -> _Gathered:
    tilt_rad = row.optional("tilt_deg", from_degrees, NUMBER, 0.0)
    found = gathered.of(key, tilt_rad)
    if found.tilt_rad != tilt_rad:
        raise row.fault("tilt_deg differs from that of an earlier line of the same condition")
    return found


def _add_force(gathered: _Conditions, row: CsvRow, sheet: Mapping[str, SheetGeometry]) -> None:
    key = _key(row, sheet)
    index = row.get("reading", integer, WHOLE)
    kind = row.optional("kind", one_of(*columns.KINDS), " or ".join(columns.KINDS), "kept")
    readings = _gathered(gathered, key, row).readings
    if index in readings:
        raise row.fault(f"column reading: reading {index} of this condition is there twice")
    readings[index] = Reading(
        index=index,
        kind=cast("Kind", kind),
        force_N=row.get("force_mN", from_milli, NUMBER),
        time_s=row.optional("time_s", from_plain, NUMBER, None),
        session_s=row.optional("session_s", from_plain, NUMBER, None),
        wetted_s=row.optional("wetted_s", from_plain, NUMBER, None),
        valid=row.optional("valid", truth, "true or false", default=True),
        why=row.optional("why", str, "a text", ""),
        other_values=row.values_after(columns.CHANNEL),
    )


def _add_point(gathered: _Conditions, row: CsvRow, sheet: Mapping[str, SheetGeometry]) -> bool:
    """Take a curve's point; says whether its condition had to be taken from its order."""
    reading = row.optional("reading", integer, WHOLE, None)
    key, unsaid = _meant(gathered, row, sheet, reading)
    found = _gathered(gathered, key, row)
    if reading is not None and reading not in found.readings:
        raise row.fault(
            f"column reading: there is no force of reading {reading}; of curves without forces only"
            " the one of the mean image is used, whose reading is left empty"
        )
    found.curves.setdefault(reading, CurvePoints()).add(row)
    return unsaid


def _meant(
    gathered: _Conditions,
    row: CsvRow,
    sheet: Mapping[str, SheetGeometry],
    reading: int | None,
) -> tuple[_Key, bool]:
    """Return the condition that a curve belongs to, and whether only the order says so.

    Where a row does not say of which run it is, the first curve is the first run's, the next one
    the next one's; approached from below comes before from above.
    """
    key = _key(row, sheet)
    if key in gathered and (row.has("run") or row.has("approach")):
        return key, False
    fit = [
        each
        for each in gathered.alike(key)
        if row.optional("approach", str, "", each.approach) == each.approach
        and row.optional("run", integer, WHOLE, each.run) == each.run
    ]
    fit.sort(key=lambda each: (each.run, each.approach == "down"))
    for each in fit:
        points = gathered[each].curves.get(reading)
        if points is None or not points.holds(row):
            return each, len(fit) > 1
    return fit[-1] if fit else key, len(fit) > 1


def _without_force(gathered: _Conditions) -> Iterator[str]:
    for key, each in gathered.items():
        if key.position_m is not None and not each.readings:
            yield (
                f"There is a curve of {key.configuration} at {milli(key.position_m)} mm and "
                f"{key.voltage_V:+g} V, but no force."
            )


def _condition(key: _Key, gathered: _Gathered) -> Condition:
    curves = {reading: points.curve() for reading, points in gathered.curves.items()}
    readings = sorted(gathered.readings.items())
    return Condition(
        configuration=key.configuration,
        position_m=key.position_m,
        voltage_V=key.voltage_V,
        readings=tuple(replace(each, curve=curves.get(index)) for index, each in readings),
        curve=curves.get(None),
        mounting=key.mounting,
        approach=cast("Literal['up', 'down', '']", key.approach),
        tilt_rad=gathered.tilt_rad,
        run=key.run,
    )


# ----------------------------------------------------------------------------------------- signals


def _series(path: Path, sheet: Mapping[str, SheetGeometry]) -> tuple[TimeSeries, ...]:
    """Return a time series for each run; times that start again begin the next run."""
    rows: dict[tuple[str, float | None, int, int], list[tuple[float, ...]]] = {}
    extras: dict[tuple[str, float | None, int, int], str] = {}
    turns: dict[tuple[str, float | None, int], int] = {}
    for row in read_rows(path, columns.SIGNALS, columns.SIGNALS_OPTIONAL):
        position_m = row.optional("position_mm", from_milli, NUMBER, None)
        mounting = row.optional("mounting", integer, WHOLE, 0)
        place = (_configuration(row, sheet), position_m, mounting)
        time_s = row.get("time_s", from_plain, NUMBER)
        turn = row.optional("run", integer, WHOLE, turns.get(place, 0))
        earlier = rows.get((*place, turn), [])
        if not row.has("run") and len(earlier) > 1 and time_s <= earlier[0][0]:
            turn += 1
        turns[place] = turn
        values = rows.setdefault((*place, turn), [])
        extras[(*place, turn)] = row.optional("extra", str, "a text", "")
        if values and time_s <= values[-1][0]:
            raise row.fault("column time_s: times must rise within a position")
        values.append(
            (
                time_s,
                row.get("drive_V", from_plain, NUMBER),
                row.optional("force_mN", from_milli, NUMBER, np.nan),
                row.optional("current_mA", from_milli, NUMBER, np.nan),
            )
        )
        if len(values) > 1 and _are_there(values[-1]) != _are_there(values[-2]):
            raise row.fault("force_mN and current_mA must be there for all of a position, or none")
    if not rows:
        raise BadInputError(f"{path}: holds no samples.")
    return tuple(
        replace(_one_series(*key, np.array(values)), extra=extras[key])
        for key, values in rows.items()
    )


def _are_there(values: tuple[float, ...]) -> list[bool]:
    return [value == value for value in values]


def _one_series(
    configuration: str, position_m: float | None, mounting: int, run: int, values: FloatArray
) -> TimeSeries:
    time_s, drive_V, force_N, current_A = values.T.copy()
    return TimeSeries(
        configuration=configuration,
        position_m=position_m,
        time_s=time_s,
        drive_V=drive_V,
        force_N=None if np.isnan(force_N).any() else force_N,
        current_A=None if np.isnan(current_A).any() else current_A,
        mounting=mounting,
        run=run,
    )
