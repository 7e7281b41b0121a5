"""CSV files into measurements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Final, Literal, NamedTuple, cast

import numpy as np

from labrig.errors import BadInputError, type_in_words
from labrig.plausibility import table_warnings
from labrig.session.tables import columns
from labrig.session.tables.camera_uncertainty import table_beside, uncertainty_in
from labrig.session.tables.csv_rows import NUMBER, CsvRow, TextTable, integer, one_of, truth
from labrig.session.tables.curve_points import CurvePoints, IntArray, numbers_of
from labrig.session.tables.decimals import from_degrees, from_milli, from_plain, milli
from labrig.session.tables.signals import SIGNAL_COLUMNS, configuration_of, series_of
from labrig.session.tables.stated import refuse_contradicted, refuse_unused
from labrig.session.tables.table import read_table
from labrig.session.tables.text.meaning import AS_NAMED, ColumnNames, ExpectedColumns
from model.measurements import Condition, Kind, Measurements, Reading, SheetGeometry, in_volts
from model.measurements.known_arguments import known_arguments

WHOLE = "a whole number from 0"
FORCE_COLUMNS: Final = ExpectedColumns(
    kind="forces", required=columns.FORCES, optional=columns.FORCES_OPTIONAL,
    prefix=columns.CHANNEL, numbered="reading",
)  # fmt: skip
CURVE_COLUMNS: Final = ExpectedColumns(
    kind="curves", required=columns.CURVES, optional=columns.CURVES_OPTIONAL,
    ignored=columns.CURVES_IGNORED, numbered="point",
)  # fmt: skip
# What the points of one curve have in common: lines in which it is the same are read together.
_OF_A_CURVE = ("configuration", "position_mm", "voltage_V", "reading", "mounting", "approach",
               "run", "tilt_deg")  # fmt: skip
_UNSAID = (
    "{} does not say of which run some of its curves are: the first curve is taken for that of the"
    " first run. The column run or approach would say it."
)


_NO_PLACE = (
    "column position_mm is empty, but there is a force; give the place of the load cell in every "
    "line, also where it is that of the line above (a force without contact has kind no_contact)"
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


@dataclass(frozen=True)
class ReadTables:
    """The measurements in some tables, and the tables as they were understood."""

    measurements: Measurements
    tables: tuple[TextTable, ...]


@known_arguments
def read_tables(
    sheet: Mapping[str, SheetGeometry],
    forces: Path | str | None,
    curves: Path | str | None = None,
    signals: Path | str | None = None,
    *,
    names: ColumnNames = AS_NAMED,
) -> Measurements:
    """Measurements from tables of forces, curves or both: CSV as labrig writes it, or others.

    `sheet`: the geometry of each configuration by its name; `labrig.measurements_of_tables` takes
    sheet.toml itself. `names` says what columns of other names mean. A camera_uncertainty.csv
    beside the curves is read with them. Raises BadInputError naming file, line and column.
    """
    if not isinstance(sheet, Mapping):  # a caller may give anything
        raise BadInputError(
            f"sheets by their names are needed, not {type_in_words(sheet)}; "
            "labrig.measurements_of_tables takes sheet.toml."
        )
    return read_and_understood(sheet, forces, curves, signals, names=names).measurements


def read_and_understood(
    sheet: Mapping[str, SheetGeometry],
    forces: Path | str | None,
    curves: Path | str | None = None,
    signals: Path | str | None = None,
    *,
    names: ColumnNames = AS_NAMED,
) -> ReadTables:
    """Return what `read_tables` does, and how each table was understood."""
    if forces is None and curves is None:
        raise BadInputError("there is neither a table of forces nor one of curves.")
    wanted = ((forces, FORCE_COLUMNS), (curves, CURVE_COLUMNS), (signals, SIGNAL_COLUMNS))
    asked = [(Path(path), expected) for path, expected in wanted if path is not None]
    names = replace(_of_sheet(names, sheet), several_tables=len(asked) > 1)
    tables = {expected.kind: read_table(path, expected, names) for path, expected in asked}
    refuse_unused(names, list(tables.values()))
    refuse_contradicted(names, list(tables.values()))
    camera = table_beside(curves)
    gathered = _Conditions()
    if forces is not None:
        for row in tables["forces"].rows():
            _add_force(gathered, row, sheet)
    unsaid = "curves" in tables and _add_curves(gathered, tables["curves"], sheet)
    if forces is not None and not any(each.readings for each in gathered.values()):
        raise BadInputError(f"{forces}: holds no readings.")
    without = _without_force(gathered) if forces is not None else ()
    found = Measurements(
        sheets=dict(sheet),
        conditions=tuple(_condition(key, each) for key, each in gathered.items()),
        series=series_of(tables["signals"], sheet) if signals is not None else (),
        source=asked[0][0].name,
        warnings=(*without, *([_UNSAID.format(curves)] if unsaid else [])),
        camera=uncertainty_in(camera),
    )
    found = replace(found, warnings=(*found.warnings, *table_warnings(found)))
    return ReadTables(found, (*tables.values(), *([] if camera is None else [camera])))


def _of_sheet(names: ColumnNames, sheet: Mapping[str, SheetGeometry]) -> ColumnNames:
    """Return the names, with the sheet's only configuration and radius where there is one alone."""
    radii_m = {one.arc_radius_m for one in sheet.values()}
    return replace(
        names,
        only_sheet=next(iter(sheet)) if len(sheet) == 1 else "",
        arc_radius_m=radii_m.pop() if len(radii_m) == 1 else None,
    )


# -------------------------------------------------------------------------------------- conditions


def _key(row: CsvRow, sheet: Mapping[str, SheetGeometry]) -> _Key:
    return _Key(
        configuration=configuration_of(row, sheet),
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
    counted = not row.has("reading")
    index = row.index if counted else row.get("reading", integer, WHOLE)
    kind = row.optional("kind", one_of(*columns.KINDS), " or ".join(columns.KINDS), "kept")
    if key.position_m is None and kind == "kept" and row.in_file("position_mm"):
        raise row.fault(_NO_PLACE)
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
        mean_of=row.optional("mean_of", _count, "a whole number from 1", 1),
        sd_N=row.optional("sd_mN", _spread, "a number from 0", None),
    )


def _count(text: str) -> int:
    if not integer(text):
        raise ValueError(text)
    return integer(text)


def _spread(text: str) -> float:
    value = from_milli(text)
    if value < 0.0:
        raise ValueError(text)
    return value


def _add_curves(
    gathered: _Conditions, table: TextTable, sheet: Mapping[str, SheetGeometry]
) -> bool:
    """Take all points; says whether the condition of some had to be taken from their order."""
    points, numbers = CurvePoints.columns_of(table), numbers_of(table, _OF_A_CURVE)
    unsaid = False
    for block, end in table.blocks(_OF_A_CURVE):
        # a number that comes again begins the next curve
        again = np.flatnonzero(np.diff(numbers[block:end]) <= 0) + block + 1
        for first, last in pairwise([block, *again.tolist(), end]):
            row = table.row(first)
            own = numbers[first:last]
            reading = row.optional("reading", integer, WHOLE, None)
            key, in_order = _meant(gathered, row, sheet, reading, own)
            unsaid |= in_order
            found = _gathered(gathered, key, row)
            if reading is not None and reading not in found.readings:
                raise row.fault(
                    f"column reading: there is no force of reading {reading}; leave the reading "
                    "of a mean curve empty"
                )
            found.curves.setdefault(reading, CurvePoints()).add(table, first, own, points)
    return unsaid


def _meant(
    gathered: _Conditions,
    row: CsvRow,
    sheet: Mapping[str, SheetGeometry],
    reading: int | None,
    numbers: IntArray,
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
        if points is None or not points.holds(numbers):
            return each, len(fit) > 1
    return fit[-1] if fit else key, len(fit) > 1


def _without_force(gathered: _Conditions) -> Iterator[str]:
    for key, each in gathered.items():
        if key.position_m is not None and not each.readings:
            yield (
                f"There is a curve of {key.configuration} at {milli(key.position_m)} mm and "
                f"{in_volts(key.voltage_V)}, but no force."
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
