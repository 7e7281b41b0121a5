"""The signals of runs over time, from a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np
import numpy.typing as npt

from drivers.interfaces import FloatArray
from labrig.errors import BadInputError
from labrig.session.tables import columns
from labrig.session.tables.csv_rows import NUMBER, CsvRow, TextTable, integer
from labrig.session.tables.decimals import from_milli, from_plain
from labrig.session.tables.text.meaning import ExpectedColumns
from model.measurements import SheetGeometry, TimeSeries

SIGNAL_COLUMNS: Final = ExpectedColumns(
    kind="signals", required=columns.SIGNALS, optional=columns.SIGNALS_OPTIONAL
)
# What the samples of one place have in common: lines in which it is the same are read together.
_OF_A_PLACE = ("configuration", "position_mm", "mounting", "run", "extra")
_Place = tuple[str, float | None, int, int | None]
_Lines = npt.NDArray[np.int64]


def configuration_of(row: CsvRow, sheet: Mapping[str, SheetGeometry]) -> str:
    """Return the configuration of a line. Raises BadInputError where the sheet has none such."""
    name = row.get("configuration", str, "a table of sheet.toml")
    if name not in sheet:
        raise row.fault(f"configuration {name!r} is no table of the sheet, {', '.join(sheet)}")
    return name


def series_of(table: TextTable, sheet: Mapping[str, SheetGeometry]) -> tuple[TimeSeries, ...]:
    """Return a time series for each run; times that start again begin the next run."""
    time_s = table.numbers("time_s", from_plain, milli=False, needed=True)
    drive_V = table.numbers("drive_V", from_plain, milli=False, needed=True)
    force_N = table.numbers("force_mN", from_milli, milli=True, needed=False)
    current_A = table.numbers("current_mA", from_milli, milli=True, needed=False)
    found = []
    for (name, position_m, mounting, run), extra, at in _runs(table, sheet, time_s):
        _check_rising(table, time_s, at)
        found.append(
            TimeSeries(
                configuration=name,
                position_m=position_m,
                time_s=time_s[at],
                drive_V=drive_V[at],
                force_N=_whole(table, force_N, at),
                current_A=_whole(table, current_A, at),
                mounting=mounting,
                run=run or 0,
                extra=extra,
            )
        )
    if not found:
        raise BadInputError(f"{table.path}: holds no samples.")
    return tuple(found)


def _runs(
    table: TextTable, sheet: Mapping[str, SheetGeometry], time_s: FloatArray
) -> Iterator[tuple[_Place, str, _Lines]]:
    """Yield each run's place, extra and lines."""
    lines: dict[_Place, list[_Lines]] = {}
    extras: dict[_Place, str] = {}
    for first, end in table.blocks(_OF_A_PLACE):
        row = table.row(first)
        place = (
            configuration_of(row, sheet),
            row.optional("position_mm", from_milli, NUMBER, None),
            row.optional("mounting", integer, "a whole number from 0", 0),
            row.optional("run", integer, "a whole number from 0", None),
        )
        lines.setdefault(place, []).append(np.arange(first, end))
        extras[place] = row.optional("extra", str, "a text", "")
    for place, parts in lines.items():
        whole = np.concatenate(parts)
        turns = _turns(time_s[whole]) if place[3] is None else [len(whole)]
        begin = 0
        for turn, end in enumerate(turns):
            run = turn if place[3] is None else place[3]
            yield (*place[:3], run), extras[place], whole[begin:end]
            begin = end


def _turns(time_s: FloatArray) -> list[int]:
    """Return where each run ends: a time that is not after a run's first one begins the next."""
    ends: list[int] = []
    begin = 0
    while True:
        again = np.flatnonzero(time_s[begin + 2 :] <= time_s[begin])
        if not again.size:
            return [*ends, len(time_s)]
        begin += 2 + int(again[0])
        ends.append(begin)


def _check_rising(table: TextTable, time_s: FloatArray, at: _Lines) -> None:
    falls = np.flatnonzero(np.diff(time_s[at]) <= 0)
    if falls.size:
        row = table.row(int(at[falls[0] + 1]))
        raise row.fault("column time_s: times must rise within a position")


def _whole(table: TextTable, values: FloatArray, at: _Lines) -> FloatArray | None:
    """Return the values of a run; None where it has none."""
    missing = np.isnan(values[at])
    if missing.all():
        return None
    if missing.any():
        row = table.row(int(at[1 + np.flatnonzero(np.diff(missing))[0]]))
        raise row.fault("force_mN and current_mA must be there for all of a position, or none")
    return values[at]
