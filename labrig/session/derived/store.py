"""Measurements kept in a session: a supplement that can be dropped and made again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from labrig.errors import BadInputError
from labrig.files import AnyPath, path_of, typed
from labrig.session.derived.arrays import (
    COLUMNS,
    UNITS,
    measurements_from_tables,
    tables_from_measurements,
)
from labrig.session.format import layout
from labrig.session.reading.opening import open_file
from labrig.session.reading.session import RecordedSession
from labrig.session.reading.values import (
    damage_told,
    read_array,
    read_dataset,
    text_attribute,
)
from labrig.session.recording.hdf5 import put_text_list, set_attributes, unit_of
from labrig.session.supplements.store import is_sealed, replaced, seal
from model.measurements import Measurements
from model.measurements.known_arguments import known_arguments

# What was made of the measurements: texts beside them, gone with them.
FINDINGS = frozenset({"diagnosis", "dynamic_comparison"})

CHANGED = (
    "The measurements kept in the session were changed by another program after they were stored; "
    "labrig analyze makes them again where the session was recorded."
)


def store_measurements(
    path: Path, measurements: Measurements, *, curve_extractor: str = ""
) -> None:
    """Keep measurements in a session, in place of those it holds. Raises BadInputError, OSError.

    `curve_extractor`: name, distribution and version of what made the curves; "": the built-in one.
    """
    with replaced(Path(path), without=layout.DERIVED) as file:
        write_derived(file, measurements, curve_extractor=curve_extractor)


@known_arguments
def load_measurements(path: AnyPath) -> Measurements:
    """Return the measurements kept in a session file that was analysed or imported.

    A recorded session that was not analysed yet has none: call `labrig.analyze` first. `labrig.fit`
    and `labrig.diagnose` do so by themselves. Raises BadInputError of one sentence.
    """
    path = path_of(path)
    with open_file(path) as file:
        if layout.DERIVED not in file:
            raise BadInputError(
                f"{path}: the session holds no measurements yet; run "
                f"labrig analyze {typed(path)} first (in Python: labrig.analyze)."
            )
        group = file[layout.DERIVED]
        tables = {
            name: read_array(read_dataset(file, f"{layout.DERIVED}/{name}", path), path)
            for name in group
            if name not in FINDINGS
        }
        warnings = _warnings(file, path)
        try:
            found = measurements_from_tables(tables)
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise BadInputError(
                f"{path}: its measurements cannot be read ({error!r}); run "
                f"labrig analyze {typed(path)} again."
            ) from None
    return replace(found, warnings=(*found.warnings, *warnings)) if warnings else found


def stored_curve_extractor(path: Path) -> str:
    """Return what made the curves of the kept measurements; "" for the built-in extractor."""
    path = path_of(path)
    with open_file(path) as file:
        group = file.get(layout.DERIVED)
        return "" if group is None else text_attribute(group, "curve_extractor")


def drop_measurements(path: Path) -> None:
    """Remove the measurements kept in a session; without any, nothing happens."""
    path = path_of(path)
    with open_file(path) as file:
        if layout.DERIVED not in file:
            return
    with replaced(path, without=layout.DERIVED):
        pass


def store_finding(path: Path, name: str, text: str) -> None:
    """Keep one of `FINDINGS` beside the measurements of a session that has some; replaces it."""
    path, where = Path(path), f"{layout.DERIVED}/{name}"
    with replaced(path) as file:
        if where in file:
            del file[where]
        content = np.frombuffer(text.encode("utf-8"), dtype=np.uint8)
        file.create_dataset(where, data=content, compression="gzip")
        seal(file[layout.DERIVED])


def load_finding(path: Path, name: str) -> str | None:
    """One of `FINDINGS` of a session; None where it holds none."""
    path, where = Path(path), f"{layout.DERIVED}/{name}"
    with open_file(path) as file:
        if where not in file:
            return None
        content = read_array(read_dataset(file, where, path), path).tobytes()
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        raise BadInputError(f"{path}: {where} is damaged; it is no text in UTF-8.") from None


def write_derived(file: Any, measurements: Measurements, *, curve_extractor: str = "") -> None:
    """Make the group in a session that has none and is open for writing."""
    group = file.create_group(layout.DERIVED)
    set_attributes(group, NX_class="NXcollection")
    if curve_extractor:
        set_attributes(group, curve_extractor=curve_extractor)
    for name, table in tables_from_measurements(measurements).items():
        packed = {"compression": "gzip", "shuffle": True} if table.size else {}
        made = group.create_dataset(name, data=table, **(packed if table.shape else {}))
        _describe(made, name)
    seal(group)


def _warnings(file: Any, path: Path) -> list[str]:
    """Return why the kept measurements may not be those of the recording, a sentence each."""
    outdated = RecordedSession(file, path).outdated if layout.MARKS in file else ""
    with damage_told(path, layout.DERIVED):
        whole = is_sealed(file[layout.DERIVED])
    return [one for one in (outdated, "" if whole else CHANGED) if one]


def _describe(dataset: Any, name: str) -> None:
    """Write the units of a table's columns, and the names of those that have none in the type."""
    if name in COLUMNS:
        put_text_list(dataset, "columns", list(COLUMNS[name]))
    columns = COLUMNS.get(name, dataset.dtype.names or ())
    if columns:
        units = [
            "" if column.startswith("has_") else UNITS.get(column, unit_of(column))
            for column in columns
        ]
        put_text_list(dataset, "column_units", units)
