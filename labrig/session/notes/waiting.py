"""Notes that wait beside a session, in a file of their own, until they are added to it.

The file is append-only, checksummed, and on the disk when `append` returns; any program may append
to it, also while another one records the session. Record 0 names the session.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, Final

from labrig.errors import BadInputError
from labrig.session.notes.note import Note, from_head
from labrig.session.recording.disk import sync_folder
from labrig.session.recording.locking import locked_file
from labrig.session.recording.records import packed, records, write_all

PATIENCE_S: Final = 10.0  # with another program that appends just now
_SESSION = "notes_of"


def waiting_path(session: Path) -> Path:
    """Where the notes of a session wait."""
    return session.parent / f"{session.name}.notes"


def holds_notes(session: Path) -> bool:
    """Whether anything waits beside a session, of whichever session it is."""
    try:
        return waiting_path(session).stat().st_size > 0
    except OSError:
        return False


def read_waiting(session: Path, identifier: str) -> list[Note]:
    """Return what waits for the session, up to the first damaged byte."""
    path = waiting_path(session)
    try:
        with path.open("rb") as file:
            return _notes(file, identifier)
    except FileNotFoundError:
        return []
    except OSError as error:
        raise BadInputError(f"{path}: cannot be read ({error.strerror}).") from None


class WaitingNotes:
    """The file, open and locked: no other program appends to it."""

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self.path = path
        self._file = file

    def read(self, identifier: str) -> list[Note]:
        """Return what waits for the session; nothing where it is another session's."""
        self._file.seek(0)
        return _notes(self._file, identifier)

    def append(self, note: Note, identifier: str) -> None:
        """Add one; it is on the disk on return. Raises BadInputError, OSError."""
        count = self._end()
        if count == 0:
            self._write(0, {_SESSION: identifier}, b"")
            count = 1
        elif self._session() != identifier:
            raise BadInputError(
                f"{self.path}: holds notes of another session; move it away, then try again."
            )
        self._write(count, note.head, note.photograph)
        os.fsync(self._file.fileno())
        sync_folder(self.path.parent)

    def clear(self) -> None:
        """Empty the file, which is then deleted: the session holds all of it."""
        self._file.truncate(0)

    def _session(self) -> str | None:
        self._file.seek(0)
        head = next(records(self._file, first=0), ({}, b""))[0]
        self._end()
        return head.get(_SESSION)

    def _end(self) -> int:
        """Go to the end of the last whole record and return the number of records."""
        self._file.seek(0)
        return sum(1 for _ in records(self._file, first=0))

    def _write(self, number: int, head: dict[str, object], blob: bytes) -> None:
        self._file.truncate()  # what a killed program has left half written
        write_all(self._file, packed(number, head, blob))


@contextmanager
def open_waiting(session: Path, *, make: bool = False) -> Iterator[WaitingNotes | None]:
    """Yield the file of a session, locked; None where there is none and none is to be made.

    Raises BadInputError when it cannot be used, or another program keeps it locked.
    """
    path = waiting_path(session)
    if not make and not path.exists():
        yield None
        return
    with locked_file(path, PATIENCE_S) as file:
        try:
            yield WaitingNotes(path, file)
        finally:
            if os.fstat(file.fileno()).st_size == 0:
                with suppress(OSError):  # Windows deletes no open file: an empty one is left
                    path.unlink()


def _notes(file: BinaryIO, identifier: str) -> list[Note]:
    found: list[Note] = []
    whole = records(file, first=0)
    if next(whole, ({}, b""))[0].get(_SESSION) != identifier:
        return found
    for head, photograph in whole:
        try:
            found.append(from_head(head, photograph))
        except (BadInputError, ValueError):  # of a later version, or of nobody
            continue
    return found
