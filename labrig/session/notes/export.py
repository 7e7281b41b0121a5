"""Files of what a session states of people, sample and devices, and of its notes."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from pathlib import Path

from labrig.config.about import FILE as ABOUT
from labrig.errors import BadInputError
from labrig.serialise import to_plain
from labrig.session.notes.note import Note
from labrig.session.notes.photograph import SUFFIXES
from labrig.session.reading.session import RecordedSession
from labrig.session.recording.disk import written_beside

DEVICES = "devices.json"
NOTES = "notes.csv"
PHOTOGRAPHS = "photographs"
_COLUMNS = ("when", "who", "text", "photograph")


def check_free(session: RecordedSession, folder: Path) -> None:
    """Raise BadInputError when a file that is to be written is there already."""
    for name in file_names(session):
        if (folder / name).exists():
            raise BadInputError(f"{folder / name} exists already; choose another folder.")


def file_names(session: RecordedSession) -> list[str]:
    """Return the names of the files that `write_about_and_notes` writes."""
    return [name for name, _ in _files(session)]


def write_about_and_notes(session: RecordedSession, folder: Path) -> list[Path]:
    """Write what there is of about.toml, devices.json, notes.csv and photographs/ to a folder."""
    written = []
    for name, content in _files(session):
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        with written_beside(path) as beside:
            beside.write_bytes(content)
        written.append(path)
    return written


def _files(session: RecordedSession) -> Iterator[tuple[str, bytes]]:
    if ABOUT in session.texts:
        yield ABOUT, session.texts[ABOUT].encode("utf-8")
    if session.devices:
        yield DEVICES, json.dumps(to_plain(session.devices), indent=2).encode("utf-8")
    notes = session.notes
    if not notes:
        return
    names = {note.identifier: _file_name(number, note) for number, note in enumerate(notes, 1)}
    table = io.StringIO(newline="")
    rows = csv.writer(table)
    rows.writerow(_COLUMNS)
    for note in notes:
        rows.writerow((note.when, note.who, note.text, names[note.identifier]))
    yield NOTES, table.getvalue().encode("utf-8")
    for note in notes:
        if note.has_photograph:
            yield names[note.identifier], session.photograph(note.identifier)


def _file_name(number: int, note: Note) -> str:
    """Return a photograph's path; its own name may be any, so it is numbered."""
    if not note.has_photograph:
        return ""
    return f"{PHOTOGRAPHS}/photograph_{number:03d}{SUFFIXES.get(note.media_type, '')}"
