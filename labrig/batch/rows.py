"""The rows of a batch: one line of JSON for each piece of work as it ends, in a file that grows.

A row counts when its line is complete and on the disk. What a crash has left of the last line is
cut off when the batch goes on. Of several rows of one piece the last one counts.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any, BinaryIO

from labrig.errors import BadInputError
from labrig.files import not_written
from labrig.serialise import finite
from labrig.session.recording.locking import locked_file

VERSION = 1
_PATIENCE_S = 2.0


class PieceOutcome(StrEnum):
    """How a piece of work ended."""

    DONE = "done"
    FAULT = "fault"  # the input, or the task, is at fault
    LOST = "lost"  # its worker was killed, each time


@dataclass(frozen=True, kw_only=True)
class Row:
    """One piece of work that has ended."""

    name: str
    key: str  # of options, version and part
    outcome: PieceOutcome
    content: str = ""  # digest of the files, as the work left them
    stamp: tuple[tuple[int, int], ...] = ()  # of the same
    sentence: str = ""  # why there is no result
    digest: str = ""  # of the whole result
    columns: dict[str, Any] = field(default_factory=dict)
    attempts: int = 1
    cpu_s: float = 0.0
    wall_s: float = 0.0
    ended: str = ""  # UTC

    def line(self) -> bytes:
        """Return the line of the file."""
        plain = {"version": VERSION, **finite(vars(self)), "outcome": self.outcome.value}
        return json.dumps(plain, ensure_ascii=False, allow_nan=False).encode("utf-8") + b"\n"


def row_of(line: bytes) -> Row | None:
    """Return the row of a line; None where it is damaged or of another version."""
    try:
        plain = json.loads(line)
        if plain.pop("version") != VERSION:
            return None
        stamp = tuple((int(a), int(b)) for a, b in plain.pop("stamp"))
        outcome = PieceOutcome(plain.pop("outcome"))
        row = Row(stamp=stamp, outcome=outcome, **plain)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None
    return row if isinstance(row.columns, dict) and isinstance(row.name, str) else None


def rows_in(path: Path) -> Iterator[Row]:
    """Yield the rows of a file in their order; damaged lines are passed over."""
    try:
        file = path.open("rb")
    except FileNotFoundError:
        return
    with file:
        for line in file:
            if line.endswith(b"\n") and (row := row_of(line)) is not None:
                yield row


class LastRows:
    """The last row of each of these names, in their order; of the rows only places are kept."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        self._path, self._names = path, names
        self._places: dict[str, int] = {}
        wanted, at = set(names), 0
        with suppress(FileNotFoundError), path.open("rb") as file:
            for line in file:
                row = row_of(line) if line.endswith(b"\n") else None
                if row is not None and row.name in wanted:
                    self._places[row.name] = at
                at += len(line)

    def __len__(self) -> int:
        """Return how many of the names have a row."""
        return len(self._places)

    def __iter__(self) -> Iterator[Row]:
        """Yield them, as often as wanted."""
        if not self._places:
            return
        with self._path.open("rb") as file:
            for name in self._names:
                if name in self._places:
                    file.seek(self._places[name])
                    row = row_of(file.readline())
                    if row is not None:
                        yield row


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
