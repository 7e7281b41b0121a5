"""How well camera and curves are known, as a table of one line beside the table of curves."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from labrig.errors import BadInputError
from labrig.session.tables import columns
from labrig.session.tables.csv_rows import TextTable
from labrig.session.tables.decimals import (
    degrees,
    from_degrees,
    from_milli,
    from_plain,
    milli,
    plain,
)
from labrig.session.tables.table import read_table
from labrig.session.tables.text.meaning import ExpectedColumns
from model.measurements import CameraUncertainty

FILE: Final = "camera_uncertainty.csv"
_COLUMNS: Final = ExpectedColumns(
    kind="camera_uncertainty", required=(), optional=columns.CAMERA, renamed=False
)
_WANTED = "a number from 0"


def table_beside(curves: Path | str | None) -> TextTable | None:
    """Return the table in the folder of a table of curves, where there is one.

    Raises BadInputError, which names file, line and column.
    """
    path = None if curves is None else Path(curves).with_name(FILE)
    if path is None or not path.is_file():
        return None
    table = read_table(path, _COLUMNS)
    if len(table.rows()) != 1:
        raise BadInputError(
            f"{path}: it has {len(table.rows())} lines of values; write one, for all curves."
        )
    return table


def uncertainty_in(table: TextTable | None) -> CameraUncertainty:
    """Return what a table states; nothing without one. Raises BadInputError."""
    if table is None:
        return CameraUncertainty()
    (row,) = table.rows()
    found = CameraUncertainty(
        scale=row.optional("scale_fraction", from_plain, _WANTED, 0.0),
        roll_rad=row.optional("roll_deg", from_degrees, _WANTED, 0.0),
        origin_m=row.optional("origin_mm", from_milli, _WANTED, 0.0),
        curve_m=row.optional("curve_mm", from_milli, _WANTED, 0.0),
    )
    for column, value in zip(columns.CAMERA, _values(found), strict=True):
        if value < 0:
            raise row.fault(f"column {column}: an uncertainty is {_WANTED}")
    return found


def cells_of(camera: CameraUncertainty) -> list[dict[str, str]]:
    """Return the line of the table; none where nothing is stated."""
    if not any(_values(camera)):
        return []
    written = (plain, degrees, milli, milli)
    return [
        {
            column: write(value) if value else ""
            for column, write, value in zip(columns.CAMERA, written, _values(camera), strict=True)
        }
    ]


def _values(camera: CameraUncertainty) -> tuple[float, ...]:
    """Return its values in the order of the columns."""
    return camera.scale, camera.roll_rad, camera.origin_m, camera.curve_m
