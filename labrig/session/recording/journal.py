"""The journal beside a session that is being written: append-only, checksummed, synced.

The session file's own metadata is rewritten in place, so a power cut can spoil it; the journal
cannot be spoilt before its last sync. It holds all that the file holds. Record 0 holds the
session's setup. A writer keeps its journal locked, so that nobody repairs a session that is still
alive.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from labrig.session.format.setup import SessionSetup
from labrig.session.recording.locking import lock, unlock
from labrig.session.recording.records import packed, records, write_all
from labrig.session.recording.rows import EventRows
from protocols.errors import ScheduleError

_MOST_ROWS = 1 << 40
# What a text that is no setup makes of itself.
_NO_SETUP = (AttributeError, KeyError, OverflowError, TypeError, ValueError)


def journal_path(session: Path) -> Path:
    """Where the journal of a session lies."""
    return session.parent / f"{session.name}.journal"  # `.` has no name that could be another


class Journal:
    """A journal that is being written. Raises OSError when the disk does."""

    def __init__(self, path: Path, setup: SessionSetup) -> None:
        self.path = path
        self._file: BinaryIO = path.open("xb", buffering=0)
        try:
            lock(self._file)
            self._number = 0
            self._write({"setup": setup.to_json()}, b"")
            self.sync()
        except BaseException:
            self._file.close()
            path.unlink(missing_ok=True)
            raise

    def append(self, rows: EventRows) -> None:
        """Add a record; it outlives this process from here on, and the computer from `sync` on."""
        head = {"path": rows.path, "at": rows.at, "count": rows.count, "packed": rows.packed}
        self._write(head, rows.blob)

    def sync(self) -> None:
        """Wait until the disk has it all."""
        os.fsync(self._file.fileno())

    def remove(self) -> None:
        """Close and delete it: the session is whole without it."""
        self.close()
        self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Let go of the file; may be called twice."""
        if not self._file.closed:
            unlock(self._file)
            self._file.close()

    def _write(self, head: dict[str, Any], blob: bytes) -> None:
        write_all(self._file, packed(self._number, head, blob))
        self._number += 1


@dataclass(frozen=True)
class JournalReader:
    """A journal as found: its setup, and its rows up to the first damaged byte."""

    path: Path
    setup: SessionSetup
    first_row: int  # byte at which the rows begin

    def rows(self) -> Iterator[EventRows]:
        """All whole records, one at a time."""
        with self.path.open("rb") as file:
            file.seek(self.first_row)
            for head, blob in records(file, first=1):
                rows = _rows(head, blob)
                if rows is None:
                    return
                yield rows

    def whole_bytes(self) -> int:
        """How many bytes from the beginning are whole records."""
        with self.path.open("rb") as file:
            for _ in records(file, first=0):
                pass
            return file.tell()


def read_journal(path: Path) -> JournalReader | None:
    """Return the journal at a path; None when not even its first record is whole."""
    try:
        with path.open("rb") as file:
            for head, _ in records(file, first=0):
                return JournalReader(path, SessionSetup.from_json(head["setup"]), file.tell())
    except FileNotFoundError:
        return None
    except (*_NO_SETUP, RecursionError, ScheduleError):
        return None
    return None


def _rows(head: dict[str, Any], blob: bytes) -> EventRows | None:
    """Return a record as rows; None when its head is none of ours."""
    match head:
        case {"path": str(path), "at": None | int() as at, "count": int(count), "packed": bool(p)}:
            if 0 <= count < _MOST_ROWS and 0 <= (at or 0) < _MOST_ROWS:
                return EventRows(path=path, at=at, count=count, blob=blob, packed=p)
    return None
