"""Mark a run or reading of a closed session invalid, or take that back."""

from __future__ import annotations

from pathlib import Path

from labrig.errors import BadInputError
from labrig.files import typed
from labrig.session.marks.mark import Mark, named
from labrig.session.marks.stored import append_mark
from labrig.session.reading.session import RecordedSession
from labrig.session.supplements.store import replaced


def add_mark(path: Path, mark: Mark) -> None:
    """Append a mark; a kill at any moment leaves the session with or without it.

    Raises BadInputError when the session is not closed, or there is no such run or reading, or it
    is marked already, or there is no mark to take back; LabrigError when the disk is full.
    """
    path = Path(path)
    with replaced(path) as file:
        session = RecordedSession(file, path)
        if not session.was_closed:
            raise BadInputError(
                f"{path}: this session was not closed; run labrig recover {typed(path)}."
            )
        _check(session, mark)
        append_mark(file, mark, session.checksum)


def _check(session: RecordedSession, mark: Mark) -> None:
    path, what = session.path, named(mark.run, mark.reading)
    run = session.run(mark.run)
    if mark.reading is not None and mark.reading not in run.readings_as_taken["index"]:
        raise BadInputError(f"{path}: {what} was not acquired; see labrig show {typed(path)}.")
    marked = run.standing_marks.get(mark.place)
    if mark.invalid and marked is not None:
        raise BadInputError(
            f"{path}: {what} is marked already, by {marked.who}: {marked.why}; --undo takes that "
            "back."
        )
    if not mark.invalid and marked is None:
        raise BadInputError(
            f"{path}: {what} has no mark that could be taken back; what the run itself found "
            "invalid stays so."
        )
