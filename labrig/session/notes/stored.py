"""Notes in the session file: a supplement with a group of the NeXus class NXnote for each."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from labrig.errors import BadInputError
from labrig.session.format import layout
from labrig.session.notes.note import PHOTOGRAPH_BYTES_MAX, Note, from_head
from labrig.session.reading.values import damage_told, read_array, read_dataset, read_text
from labrig.session.recording.hdf5 import put_text, set_attributes
from labrig.session.supplements.store import is_sealed, seal

_GROUP = re.compile(r"note_\d{4,9}")
# Our names, and those of NXnote.
_TEXTS = {
    "identifier": "identifier",
    "who": "author",
    "when": "date",
    "text": "description",
    "media_type": "type",
    "file_name": "file_name",
}


def add_to_file(file: Any, notes: Iterable[Note]) -> int:
    """Append those that the file, open for writing, does not hold yet; return how many.

    Raises BadInputError when the notes in the file were changed since they were added.
    """
    path = Path(file.filename)
    if layout.NOTES not in file:
        set_attributes(file.create_group(layout.NOTES), NX_class="NXcollection")
    elif not is_sealed(file[layout.NOTES]):
        raise BadInputError(
            f"{path}: its notes were changed by another program; see labrig verify."
        )
    group = file[layout.NOTES]
    known = {note.identifier for note in read_stored(file, path)}
    new = [note for note in notes if note.identifier not in known]
    for number, note in enumerate(new, len(known) + 1):
        _write(group.create_group(f"note_{number:04d}"), note, number)
    seal(group)
    return len(new)


def read_stored(file: Any, path: Path, *, photographs: bool = False) -> list[Note]:
    """Return the notes of an open file in their order, with or without their photographs."""
    return [_read(file, name, path, photographs=photographs) for name in _names(file, path)]


def read_photograph(file: Any, path: Path, identifier: str) -> bytes:
    """Return the photograph of a note; nothing where the file does not hold it."""
    for name in _names(file, path):
        if read_text(file, f"{name}/identifier", path) == identifier:
            return _photograph(file, name, path)
    return b""


def _names(file: Any, path: Path) -> list[str]:
    with damage_told(path, layout.NOTES):
        group = file.get(layout.NOTES, ())
        if isinstance(group, h5py.Dataset):
            raise BadInputError(f"{path}: {layout.NOTES} is no group, which it is in a session.")
        names = filter(_GROUP.fullmatch, group)
        return [f"{layout.NOTES}/{name}" for name in sorted(names, key=_number)]


def _number(name: str) -> int:
    return int(name.rpartition("_")[2])


def _write(group: Any, note: Note, number: int) -> None:
    set_attributes(group, NX_class="NXnote")
    for ours, name in _TEXTS.items():
        put_text(group, name, getattr(note, ours))
    group.create_dataset("sequence_index", data=np.int32(number))
    if note.photograph:
        group.create_dataset("data", data=np.frombuffer(note.photograph, dtype=np.uint8))


def _read(file: Any, name: str, path: Path, *, photographs: bool) -> Note:
    head = {ours: read_text(file, f"{name}/{there}", path) for ours, there in _TEXTS.items()}
    try:
        return from_head(head, _photograph(file, name, path) if photographs else b"")
    except (BadInputError, ValueError) as error:
        raise BadInputError(f"{path}: {name} is damaged ({error}).") from None


def _photograph(file: Any, name: str, path: Path) -> bytes:
    if f"{name}/data" not in file:
        return b""
    dataset = read_dataset(file, f"{name}/data", path)
    if dataset.dtype != np.uint8 or dataset.ndim != 1 or dataset.size > PHOTOGRAPH_BYTES_MAX:
        raise BadInputError(f"{path}: {name}/data is no photograph.")
    return read_array(dataset, path).tobytes()
