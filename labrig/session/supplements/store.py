"""Write supplements: the recording is copied as it is, its supplements may change.

The session is copied beside, the copy is changed and takes the session's place, so a crash at any
moment leaves the session as it was or as it was to be. Programs wait for one another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from labrig.session.format import layout
from labrig.session.format.checksums import SUPPLEMENT_SUM, supplement_digest, version_of
from labrig.session.reading.opening import check_is_hdf5, open_file
from labrig.session.reading.values import damage_told, text_attribute
from labrig.session.recording.disk import written_beside
from labrig.session.recording.hdf5 import set_attributes
from labrig.session.recording.locking import only_writer


@contextmanager
def replaced(path: Path, *, without: str = "") -> Iterator[Any]:
    """Yield a copy of the session to write into, `without` a supplement; it replaces the session.

    Nothing changes when the caller raises. Raises BadInputError, LabrigError.
    """
    check_is_hdf5(path)
    # Left in the reverse order: a file that is open cannot be replaced everywhere.
    with (
        only_writer(path),
        written_beside(path) as beside,
        open_file(path) as old,
        h5py.File(beside, "x", libver=layout.LIBVER) as new,
    ):
        with damage_told(path):
            _copy(old, new, without)
        yield new


def check_can_be_added_to(path: Path) -> None:
    """Raise BadInputError where a session cannot be replaced: before the work that it is for."""
    check_is_hdf5(path)
    with only_writer(path):
        pass


def store_supplement(path: Path, name: str, write: Callable[[Any], None]) -> None:
    """Put a supplement in place of the one that the session has, if any.

    `write` fills its empty group; texts and types are of fixed length (see `layout`).
    """
    with replaced(Path(path), without=name) as file:
        group = file.create_group(name)
        set_attributes(group, NX_class="NXcollection")
        write(group)
        seal(group)


def seal(group: Any) -> None:
    """Write the checksum of a supplement that is complete."""
    set_attributes(group, **{SUPPLEMENT_SUM: supplement_digest(group, version_of(group.file))})


def is_sealed(group: Any) -> bool:
    """Whether a supplement is as it was when its checksum was written. Raises OSError."""
    if not isinstance(group, h5py.Group):
        return False
    try:
        wanted = supplement_digest(group, version_of(group.file))
    except ValueError:  # an attribute of a type that no session holds
        return False
    return text_attribute(group, SUPPLEMENT_SUM) == wanted


def _copy(old: Any, new: Any, without: str) -> None:
    _copy_attributes(old, new)
    entry = new.create_group(layout.ENTRY)
    _copy_attributes(old[layout.ENTRY], entry)
    for name in old[layout.ENTRY]:
        if f"{layout.ENTRY}/{name}" != without:
            # Moves the chunks as they are on the disk, so frames are not unpacked.
            old.copy(f"{layout.ENTRY}/{name}", entry)


def _copy_attributes(source: Any, target: Any) -> None:
    for name in source.attrs:
        kind = source.attrs.get_id(name).dtype
        target.attrs.create(name, source.attrs[name], dtype=kind)
