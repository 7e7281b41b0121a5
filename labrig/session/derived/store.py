"""Measurements kept in a session: a group of its own that can be dropped and made again.

The session is copied beside, the copy gets the group and takes the session's place, so a crash at
any moment leaves the session as it was or as it was to be.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from labrig.errors import BadInputError
from labrig.session.derived.arrays import measurements_from_tables, tables_from_measurements
from labrig.session.format import layout
from labrig.session.reading.opening import open_file
from labrig.session.reading.values import damage_told, read_array, read_dataset
from labrig.session.recording.create import set_attributes
from labrig.session.recording.disk import written_beside
from labrig.session.recording.recorder import digest
from model.measurements import Measurements

# What was made of the measurements: texts beside them, gone with them.
FINDINGS = frozenset({"diagnosis"})


def store_measurements(
    path: Path, measurements: Measurements, *, curve_extractor: str = ""
) -> None:
    """Keep measurements in a session, in place of those it holds. Raises BadInputError, OSError.

    `curve_extractor`: name, distribution and version of what made the curves; "": the built-in one.
    """
    with _remade(Path(path)) as file:
        write_derived(file, measurements)
        if curve_extractor:
            set_attributes(file[layout.DERIVED], curve_extractor=curve_extractor)


def load_measurements(path: Path) -> Measurements:
    """Return the measurements kept in a session. Raises BadInputError when there are none."""
    path = Path(path)
    with open_file(path) as file:
        if layout.DERIVED not in file:
            raise BadInputError(
                f"{path}: the session holds no measurements yet; run labrig analyze {path} first."
            )
        group = file[layout.DERIVED]
        tables = {
            name: read_array(read_dataset(file, f"{layout.DERIVED}/{name}", path), path)
            for name in group
            if name not in FINDINGS
        }
        try:
            return measurements_from_tables(tables)
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise BadInputError(
                f"{path}: its measurements cannot be read ({error!r}); run labrig analyze {path} "
                "again."
            ) from None


def stored_curve_extractor(path: Path) -> str:
    """Return what made the curves of the kept measurements; "" for the built-in extractor."""
    path = Path(path)
    with open_file(path) as file:
        group = file.get(layout.DERIVED)
        made_by = b"" if group is None else group.attrs.get("curve_extractor", b"")
    return bytes(made_by).decode("utf-8", errors="replace")


def drop_measurements(path: Path) -> None:
    """Remove the measurements kept in a session; without any, nothing happens."""
    path = Path(path)
    with open_file(path) as file:
        if layout.DERIVED not in file:
            return
    with _remade(path):
        pass


def store_finding(path: Path, name: str, text: str) -> None:
    """Keep one of `FINDINGS` beside the measurements of a session that has some; replaces it."""
    path, where = Path(path), f"{layout.DERIVED}/{name}"
    with (
        written_beside(path) as beside,
        open_file(path) as old,
        h5py.File(beside, "x", libver=layout.LIBVER) as new,
    ):
        with damage_told(path):
            _copy_raw(old, new)
            old.copy(layout.DERIVED, new[layout.ENTRY])
        if where in new:
            del new[where]
        content = np.frombuffer(text.encode("utf-8"), dtype=np.uint8)
        new.create_dataset(where, data=content, compression="gzip")
        group = new[layout.DERIVED]
        set_attributes(group, sha256=derived_digest(group))


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


def write_derived(file: Any, measurements: Measurements) -> None:
    """Make the group in a session that has none and is open for writing."""
    group = file.create_group(layout.DERIVED)
    set_attributes(group, NX_class="NXcollection")
    for name, table in tables_from_measurements(measurements).items():
        packed = {"compression": "gzip", "shuffle": True} if table.size else {}
        group.create_dataset(name, data=table, **(packed if table.shape else {}))
    set_attributes(group, sha256=derived_digest(group))


def derived_digest(group: Any) -> str:
    """Return the sha256 over all tables of the group."""
    total = hashlib.sha256()
    for name in sorted(group):
        total.update(f"{name} {digest(group[name])}\n".encode())
    return total.hexdigest()


@contextmanager
def _remade(path: Path) -> Iterator[Any]:
    """Yield a copy of the session without measurements, to write into; it replaces the session."""
    # Left in the reverse order: a file that is open cannot be replaced everywhere.
    with (
        written_beside(path) as beside,
        open_file(path) as old,
        h5py.File(beside, "x", libver=layout.LIBVER) as new,
    ):
        with damage_told(path):
            _copy_raw(old, new)
        yield new


def _copy_raw(old: Any, new: Any) -> None:
    _copy_attributes(old, new)
    entry = new.create_group(layout.ENTRY)
    _copy_attributes(old[layout.ENTRY], entry)
    for name in old[layout.ENTRY]:
        if f"{layout.ENTRY}/{name}" != layout.DERIVED:
            # Moves the chunks as they are on the disk, so frames are not unpacked.
            old.copy(f"{layout.ENTRY}/{name}", entry)


def _copy_attributes(source: Any, target: Any) -> None:
    for name in source.attrs:
        kind = source.attrs.get_id(name).dtype
        target.attrs.create(name, source.attrs[name], dtype=kind)
