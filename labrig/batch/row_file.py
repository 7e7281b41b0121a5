"""The file of rows, open for appending: what is in it is on the disk."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from labrig.batch.rows import Row
from labrig.errors import BadInputError
from labrig.files import not_written
from labrig.session.recording.locking import locked_file

_PATIENCE_S = 2.0


class RowFile:
    """The file, open and locked for appending."""

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self._path, self._file = path, file
        _cut_torn_line(file)

    def append(self, rows: Iterable[Row]) -> None:
        """Write rows and see them onto the disk. Raises LabrigError where that is full."""
        try:
            whole = b"".join(row.line() for row in rows)
            while whole:
                whole = whole[self._file.write(whole) :]
            os.fsync(self._file.fileno())
        except OSError as error:
            raise not_written(self._path, error) from None


@contextmanager
def row_file(path: Path) -> Iterator[RowFile]:
    """Open the rows to append to; one program at a time. Raises BadInputError."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(path.parent, error) from None
    with locked_file(path, _PATIENCE_S) as file:
        try:
            yield RowFile(path, file)
        except BlockingIOError as error:
            raise BadInputError(f"{path}: cannot be written ({error.strerror}).") from None


def _cut_torn_line(file: BinaryIO) -> None:
    """Cut off what a crash has left of a line, and stand at the end."""
    end = file.seek(0, os.SEEK_END)
    step = 1 << 16
    at = end
    while at > 0:
        start = max(0, at - step)
        file.seek(start)
        found = file.read(at - start).rfind(b"\n")
        if found >= 0:
            keep = start + found + 1
            break
        at = start
    else:
        keep = 0
    if keep < end:
        file.truncate(keep)
    file.seek(0, os.SEEK_END)
