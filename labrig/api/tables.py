"""`labrig.measurements_of_tables`: what was measured, from CSV tables of any program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from labrig.api.arguments import several, texts
from labrig.api.data import Data, measurements_of, paths_of, tell
from labrig.errors import BadArgumentError, BadInputError
from labrig.files import AnyPath, path_of
from labrig.progress import Progress
from model.measurements import Measurements
from model.measurements.known_arguments import known_arguments

Names = Mapping[str, object] | Sequence[str]  # {"force_mN": "F"}, or ["force_mN=F"]


@known_arguments
def measurements_of_tables(
    sheet: AnyPath | None,
    forces: AnyPath | None = None,
    curves: AnyPath | None = None,
    signals: AnyPath | None = None,
    *,
    columns: Names = (),
    values: Names = (),
    ignore: str | Sequence[str] = (),
) -> Measurements:
    """Read CSV tables of a sheet, as `labrig fit --sheet` does; other programs' tables, too.

    Args:
        sheet: sheet.toml.
        forces: a table of forces.
        curves: a table of curves.
        signals: a table of signals.
        columns: which column of the tables is which of labrig's: {"force_mN": "F"}, or
            ["force_mN=F"]. Several names for one column, {"voltage_V": ["U", "Spannung"]}: each
            table takes the first that it has.
        values: a value that no column has, the same in all lines: {"configuration": "long"}.
        ignore: columns of the tables to leave out, such as "Nr".

    Returns:
        Measurements: for `labrig.fit` and all other functions that take measurements.

    Raises:
        BadInputError: one sentence that names file, line and column.

    A `LabrigWarning` says how a table was understood that is not written as labrig writes it.

    Example:
        >>> labrig.measurements_of_tables(  # doctest: +SKIP
        ...     "sheet.toml", "labview.txt",
        ...     columns={"position_mm": "p", "voltage_V": "U", "force_mN": "F"},
        ...     values={"configuration": "long"},
        ... )

    """
    if sheet is None or (forces is None and curves is None):
        raise BadArgumentError(
            "give a session, or CSV tables with sheet and forces, curves or both.",
            "sheet", "forces", "curves",
        )  # fmt: skip
    from labrig.config import load_sheet
    from labrig.session.tables import column_names, read_and_understood
    from labrig.session.tables.preview import in_one_line, remarks

    names = column_names(_pairs(columns), _pairs(values), texts(ignore))
    tables = [None if path is None else path_of(path) for path in (forces, curves, signals)]
    found = read_and_understood(load_sheet(path_of(sheet)), *tables, names=names)
    for table in found.tables:
        for text in filter(None, (in_one_line(table), *remarks(table))):
            tell(text)
    for text in found.measurements.warnings:
        tell(text)
    return found.measurements


def _pairs(names: Names) -> list[str]:
    """Return `ours=theirs` of each name."""
    if isinstance(names, Mapping):
        return [f"{ours}={one}" for ours, theirs in names.items() for one in _each(theirs)]
    return several(names)


def _each(theirs: object) -> list[object]:
    """Return the names of one column; a value that is no list is one."""
    return list(theirs) if isinstance(theirs, list | tuple) else [theirs]


@dataclass(frozen=True, kw_only=True)
class GivenTables:
    """The tables that an argument or an option names, and what their columns mean."""

    sheet: AnyPath | None = None
    forces: AnyPath | None = None
    curves: AnyPath | None = None
    signals: AnyPath | None = None
    columns: Names = ()
    values: Names = ()
    ignore: str | Sequence[str] = ()

    def __bool__(self) -> bool:
        """Whether anything was given."""
        paths = (self.sheet, self.forces, self.curves, self.signals)
        return any(path is not None for path in paths) or bool(
            self.columns or self.values or self.ignore
        )

    def read(self) -> Measurements:
        """Return their measurements."""
        return measurements_of_tables(
            self.sheet, self.forces, self.curves, self.signals,
            columns=self.columns, values=self.values, ignore=self.ignore,
        )  # fmt: skip


def data_of(
    sessions: Data | Sequence[AnyPath] | None, tables: GivenTables, progress: Progress | None
) -> Measurements:
    """Return the measurements of sessions, or of tables."""
    given = sessions is not None and (isinstance(sessions, Measurements) or paths_of(sessions))
    if given and tables:
        raise BadInputError("give either a session or CSV tables, not both.")
    if sessions is not None and given:
        return measurements_of(sessions, progress)
    return tables.read()
