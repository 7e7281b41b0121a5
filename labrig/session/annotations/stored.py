"""Annotations in the session file: an NXnote group each, in a chain of checksums."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from labrig.errors import BadInputError
from labrig.session.annotations.annotation import CONTENT_BYTES_MAX, Annotation, from_head
from labrig.session.format import layout
from labrig.session.reading.values import damage_told, read_array, read_dataset, read_text
from labrig.session.recording.create import put_text, set_attributes

_NAME = re.compile(r"annotation_(\d{4,9})")
# Our names and those of the NeXus class NXnote, where it has one.
_TEXTS = {
    "kind": "kind",
    "identifier": "identifier",
    "who": "author",
    "when": "date",
    "text": "description",
    "media_type": "type",
    "file_name": "file_name",
}
_NUMBERS = ("run", "reading")


def add_to_file(file: Any, annotations: Iterable[Annotation]) -> int:
    """Append those that the file, open for writing, does not hold yet; return how many."""
    path = Path(file.filename)
    if layout.ANNOTATIONS not in file:
        group = file.create_group(layout.ANNOTATIONS)
        set_attributes(group, NX_class="NXcollection")
    known = {one.identifier for one in read_stored(file, path)}
    previous, number = _last(file, path)
    added = 0
    for one in annotations:
        if one.identifier not in known:
            number, previous = number + 1, one.checksum(previous)
            _write(file[layout.ANNOTATIONS], number, one, previous)
            known.add(one.identifier)
            added += 1
    return added


def read_stored(file: Any, path: Path, *, content: bool = False) -> list[Annotation]:
    """Return the annotations of an open file in their order, with or without their content."""
    return [_read(file, name, path, content=content) for name in _names(file, path)]


def read_content(file: Any, path: Path, identifier: str) -> bytes | None:
    """Return the content of one annotation; None where the file does not hold it."""
    for name in _names(file, path):
        if read_text(file, f"{name}/identifier", path) == identifier:
            return _content(file, name, path)
    return None


def changed(file: Any, path: Path) -> tuple[int, list[str]]:
    """Return the number of annotations, and the names of those that are not as they were added."""
    previous, faults = _first(file, path), []
    names = _names(file, path)
    for expected, name in enumerate(names, 1):
        try:
            one = _read(file, name, path, content=True)
            stored = read_text(file, f"{name}/sha256", path)
        except BadInputError:
            faults.append(name)
            continue
        if stored != one.checksum(previous) or _number(name) != expected:
            faults.append(name)
        previous = stored
    return len(names), faults


def _names(file: Any, path: Path) -> list[str]:
    with damage_told(path, layout.ANNOTATIONS):
        group = file.get(layout.ANNOTATIONS)
        found = [] if group is None else sorted(filter(_NAME.fullmatch, group), key=_number)
    return [f"{layout.ANNOTATIONS}/{name}" for name in found]


def _number(name: str) -> int:
    return int(name.rpartition("_")[2])


def _first(file: Any, path: Path) -> str:
    """Return the beginning of the chain: annotations belong to this session and no other."""
    return read_text(file, f"{layout.ENTRY}/identifier", path)


def _last(file: Any, path: Path) -> tuple[str, int]:
    """Return the checksum and the number of the newest annotation."""
    names = _names(file, path)
    if not names:
        return _first(file, path), 0
    return read_text(file, f"{names[-1]}/sha256", path), _number(names[-1])


def _write(folder: Any, number: int, one: Annotation, checksum: str) -> None:
    group = folder.create_group(f"annotation_{number:04d}")
    set_attributes(group, NX_class="NXnote")
    for ours, name in _TEXTS.items():
        put_text(group, name, getattr(one, ours))
    for name in _NUMBERS:
        group.create_dataset(name, data=np.int32(getattr(one, name)))
    group.create_dataset("sequence_index", data=np.int32(number))
    if one.content:
        group.create_dataset("data", data=np.frombuffer(one.content, dtype=np.uint8))
    put_text(group, "sha256", checksum)


def _read(file: Any, name: str, path: Path, *, content: bool) -> Annotation:
    head: dict[str, Any] = {
        ours: read_text(file, f"{name}/{there}", path) for ours, there in _TEXTS.items()
    }
    for number in _NUMBERS:
        value = read_array(read_dataset(file, f"{name}/{number}", path), path)
        if value.shape != () or value.dtype.kind != "i":
            raise BadInputError(f"{path}: {name}/{number} is no number.")
        head[number] = int(value)
    try:
        return from_head(head, _content(file, name, path) if content else b"")
    except ValueError:
        raise BadInputError(f"{path}: {name} is no annotation.") from None


def _content(file: Any, name: str, path: Path) -> bytes:
    if f"{name}/data" not in file:
        return b""
    dataset = read_dataset(file, f"{name}/data", path)
    if dataset.dtype != np.uint8 or dataset.ndim != 1 or dataset.size > CONTENT_BYTES_MAX:
        raise BadInputError(f"{path}: {name}/data is no photograph.")
    return read_array(dataset, path).tobytes()
