"""Adds notes to a session: beside it at once, and into its file when that is closed.

A kill at any moment loses no note, as it is deleted beside the file only when the file holds it,
and doubles none, as each has an identifier.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from labrig.errors import BadInputError, LabrigError
from labrig.files import AnyPath, path_of
from labrig.session.notes.note import NAME_CHARACTERS_MAX, Note
from labrig.session.notes.stored import add_to_file
from labrig.session.notes.waiting import WaitingNotes, open_waiting
from labrig.session.reading.session import open_session
from labrig.session.recording.disk import cause
from labrig.session.recording.journal import journal_path, read_journal
from labrig.session.recording.locking import is_locked
from labrig.session.supplements.store import replaced
from model.measurements.known_arguments import known_arguments


@known_arguments
def add_note(path: AnyPath, note: Note | str) -> bool:
    """Add a note to a session that is closed, being recorded, or cut short.

    `note` is a `Note`, or its text alone: it is then by the operators that the session states.
    It is on the disk on return: in the file (True), or beside it (False) until the session is
    closed or recovered, or the disk takes a copy of it. Raises BadInputError, LabrigError.
    """
    path = path_of(path)
    if not isinstance(note, Note):
        if not isinstance(note, str):  # a caller may give anything
            raise BadInputError(f"A note is a text or a labrig.Note, not {note!r}.")
        note = Note(who=stated_operators(path), text=note)
    identifier = _identifier(path)
    with open_waiting(path, make=True) as waiting:
        assert waiting is not None  # noqa: S101 - it was made
        try:
            waiting.append(note, identifier)
        except OSError as error:
            raise BadInputError(f"{waiting.path}: cannot be written ({cause(error)}).") from None
        if journal_path(path).exists():
            return False
        with suppress(LabrigError):  # the note is kept: to report a failure would have it twice
            _add(path, identifier, waiting)
            return True
    return False


def stated_operators(path: Path) -> str:
    """Return those whom a session states; one that was cut short opens only when recovered."""
    try:
        with open_session(path, live=True) as session:
            return ", ".join(session.about.operators)[:NAME_CHARACTERS_MAX]
    except BadInputError:
        return ""


def add_waiting(path: Path) -> int:
    """Add what waits beside a closed session to its file; return how many notes.

    Raises BadInputError when the session is not closed, LabrigError when the disk takes no more;
    then all of it still waits, and is shown with the session.
    """
    path = path_of(path)
    with open_waiting(path) as waiting:
        if waiting is None:
            return 0
        with open_session(path) as session:
            identifier = session.identifier
        return _add(path, identifier, waiting)


def _identifier(path: Path) -> str:
    """Return the session's identifier; its journal states it when the file does not open.

    Raises BadInputError for a closed session whose notes were changed since they were added.
    """
    journal = read_journal(journal_path(path)) if path.exists() else None
    if journal is not None:
        return journal.setup.identifier
    live = is_locked(journal_path(path))
    with open_session(path, live=live) as session:
        if session.notes_were_changed:
            raise BadInputError(
                f"{path}: its notes were changed by another program; nothing is added to them."
            )
        return session.identifier


def _add(path: Path, identifier: str, waiting: WaitingNotes) -> int:
    notes = waiting.read(identifier)
    if not notes:
        return 0
    with replaced(path) as file:
        added = add_to_file(file, notes)
    waiting.clear()
    return added
