"""Marks in the session file: an append-only table whose rows each carry a checksum.

The checksum of a row covers the row and the checksum of the row before it; the first one covers the
checksum of the recording. So no row can be changed, moved or taken out without a trace.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from labrig.errors import BadInputError
from labrig.session.format import layout
from labrig.session.format.layout import Array
from labrig.session.marks.mark import Mark
from labrig.session.reading.values import damage_told, read_array, read_dataset, with_str
from labrig.session.recording.hdf5 import set_attributes
from labrig.session.supplements.store import is_sealed, seal

_TABLE = f"{layout.MARKS}/entries"
_ROWS_IN_CHUNK = 16


def read_marks(file: Any, path: Path) -> tuple[Mark, ...]:
    """Return the marks after the end of an open session, oldest first. Raises BadInputError."""
    return tuple(
        Mark(
            run=int(row["run"]),
            reading=None if row["reading"] < 0 else int(row["reading"]),
            invalid=bool(row["invalid"]),
            why=str(row["why"]),
            who=str(row["who"]),
            when=str(row["when"]),
        )
        for row in with_str(_rows(file, path))
    )


def chain_holds(file: Any, path: Path, checksum: str) -> bool:
    """Whether every mark is as it was when it was made; `checksum` is that of the recording."""
    before = checksum
    for row in _rows(file, path):
        if bytes(row["sha256"]).decode("ascii", "replace") != _row_digest(row, before):
            return False
        before = bytes(row["sha256"]).decode("ascii")
    return True


def append_mark(file: Any, mark: Mark, checksum: str) -> None:
    """Append a mark to a session that is open for writing.

    Raises BadInputError where marks were changed by something else.
    """
    path = Path(file.filename)
    if layout.MARKS not in file:
        _make_group(file)
    elif not (is_sealed(file[layout.MARKS]) and chain_holds(file, path, checksum)):
        raise BadInputError(
            f"{path}: its marks were changed by another program; see labrig verify."
        )
    table = file[_TABLE]
    count = table.shape[0]
    before = bytes(table[-1]["sha256"]).decode("ascii") if count else checksum
    table.resize(count + 1, axis=0)
    table[count] = _row(mark, before)
    seal(file[layout.MARKS])


def _make_group(file: Any) -> None:
    set_attributes(file.create_group(layout.MARKS), NX_class="NXcollection")
    chunks = (_ROWS_IN_CHUNK,)
    table = file.create_dataset(
        _TABLE, shape=(0,), maxshape=(None,), chunks=chunks, dtype=layout.END_MARK_ROW
    )
    set_attributes(table, comment=layout.END_MARKS_COMMENT)


def _rows(file: Any, path: Path) -> Array:
    with damage_told(path, layout.MARKS):
        if layout.MARKS not in file:
            return np.zeros(0, dtype=layout.END_MARK_ROW)
    dataset = read_dataset(file, _TABLE, path)
    if dataset.dtype != layout.END_MARK_ROW or len(dataset.shape) != 1:
        raise BadInputError(f"{path}: {_TABLE} has other columns than marks have.")
    return read_array(dataset, path)


def _row(mark: Mark, before: str) -> Any:
    row = np.zeros((), dtype=layout.END_MARK_ROW)
    row["when"], row["run"] = mark.when.encode("ascii"), mark.run
    row["reading"] = -1 if mark.reading is None else mark.reading
    row["invalid"] = mark.invalid
    row["why"], row["who"] = mark.why.encode("utf-8"), mark.who.encode("utf-8")
    row["sha256"] = _row_digest(row, before).encode("ascii")
    return row


def _row_digest(row: Any, before: str) -> str:
    """Return the checksum of a row that follows the one of checksum `before`."""
    values = [row[name].item() for name in layout.END_MARK_ROW.names or () if name != "sha256"]
    return hashlib.sha256(f"{before} {values!r}".encode()).hexdigest()
