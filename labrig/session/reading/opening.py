"""Opens a session file that may come from anywhere, and says in a sentence why it cannot be.

Only what the layout names is believed: texts of fixed length, arrays of numbers, no links.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5d, h5g, h5l, h5o

from drivers.interfaces import RealClock
from labrig.config.file_kinds import SESSION, kind_of_file, other_kind
from labrig.errors import BadInputError
from labrig.files import typed
from labrig.session.format import layout
from labrig.session.reading.guard_report import read_guard_report
from labrig.session.reading.values import damage_told
from labrig.session.recording.journal import journal_path
from labrig.session.recording.locking import is_locked

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
# Deflate cannot pack denser than 1 : 1032; a file that claims more holds nothing but the claim.
_DENSEST = 1100
_SMALL_BYTES = 1 << 20
_BEGINS_S, _AGAIN_S = 3.0, 0.05
_DEEPEST = 8  # groups in one another; a session has five


def open_file(path: Path, *, live: bool = False) -> Any:
    """Return the HDF5 file, read-only and checked. Raises BadInputError.

    `live` also opens a session that is being recorded right now, as it stands.
    """
    check_is_hdf5(path)
    # The library would wait practically for ever for a writer that is dead to finish its work.
    live = live and is_locked(journal_path(path))
    file = _open_live(path) if live else _open(path)
    try:
        with damage_told(path):
            check_format(file, path)
            check_objects(file, path)
    except BaseException:
        file.close()
        raise
    return file


def _open(path: Path, **how: Any) -> Any:
    try:
        return h5py.File(path, "r", **how)
    except OSError as error:
        raise BadInputError(_why_not(path, error)) from None


def _open_live(path: Path) -> Any:
    """Return a file that is being written: one that has just begun takes a moment to allow it.

    Its writer has not locked it, and HDF5 wants the same of all in one process.
    """
    clock = RealClock()
    until_s = clock.now() + _BEGINS_S
    while True:
        try:
            return _open(path, swmr=True, libver=layout.LIBVER, locking=False)
        except BadInputError:
            if clock.now() > until_s:
                raise
        clock.sleep_until(clock.now() + _AGAIN_S)


def check_is_hdf5(path: Path) -> None:
    """Raise BadInputError unless the path is a file that begins like HDF5."""
    try:
        if not (path.is_file() or path.is_dir() or not path.exists()):
            raise BadInputError(  # a pipe would be waited for
                f"{path}: this is a device or a pipe, an ordinary file is needed."
            )
        with path.open("rb") as file:
            begin = file.read(len(_SIGNATURE))
    except FileNotFoundError:
        raise BadInputError(f"{path}: there is no such file.") from None
    except IsADirectoryError:
        raise BadInputError(f"{path}: this is a folder; a session file is needed.") from None
    except OSError as error:
        raise BadInputError(f"{path}: cannot be read ({error.strerror}).") from None
    if begin != _SIGNATURE:
        has_journal = journal_path(path).exists()
        kind = "" if has_journal else kind_of_file(path)
        if kind:
            raise other_kind(path, kind, SESSION)
        said = "is empty" if not begin else "is not an HDF5 file"
        made = "; labrig import makes one of tables" if begin else ""
        hint = f"; run labrig recover {typed(path)}" if has_journal else made
        raise BadInputError(f"{path}: {said}, so it is no session{hint}.")


def _why_not(path: Path, error: OSError) -> str:
    text = str(error)
    if "already open for write" in text or "consistency flags" in text:
        return cut_short(path)
    if "truncated" in text:
        return (
            f"{path}: the file is truncated; fetch it again, or, where its journal still lies "
            f"beside it, run labrig recover {typed(path)}."
        )
    if "unable to lock" in text:
        return f"{path}: another program has the file open for writing; close it and try again."
    return f"{path}: the file is damaged ({text}); try labrig recover {typed(path)}."


def cut_short(path: Path) -> str:
    """Return the sentence about a session without an end."""
    recovered = recovered_beside(path)
    # one of an earlier session of this name is older than what is recorded now
    if recovered.exists() and recovered.stat().st_mtime >= path.stat().st_mtime:
        return (
            f"{path}: its recording was cut short; what could be saved of it is in "
            f"{typed(recovered)}."
        )
    guard = read_guard_report(path)
    if guard is not None:
        return f"{path}: {guard.text}; run labrig recover {typed(path)}."
    return (
        f"{path}: this session is being recorded right now, or its recording was cut short; in "
        f"that case run labrig recover {typed(path)}."
    )


def recovered_beside(path: Path) -> Path:
    """Return where `labrig recover` puts what it saves of a session."""
    return path.parent / f"{path.stem}-recovered{path.suffix}"


def check_format(file: Any, path: Path) -> None:
    """Raise BadInputError unless the file says that it is a session of this version."""
    found = file.attrs.get("labrig_format")
    if found is None or not isinstance(found, (int, np.integer)):
        raise BadInputError(f"{path}: this HDF5 file is no labrig session.")
    if int(found) not in layout.READABLE:
        raise BadInputError(
            f"{path}: the session has format {int(found)} and this labrig reads formats "
            f"{layout.READABLE[0]} to {layout.READABLE[-1]}; use a newer labrig."
        )


def check_objects(file: Any, path: Path) -> None:
    """Raise BadInputError when the file holds anything that a session never holds.

    By the library's own calls: h5py's objects would take twice as long, at each opening.
    """
    size = path.stat().st_size
    seen = {_place(file.id)}

    def visit(group: Any, inside: str, depth: int) -> None:
        for raw in group:
            where = f"{inside}/{raw.decode('utf-8', 'surrogateescape')}"
            if layout.in_additional(where):
                continue
            kind = group.links.get_info(raw).type
            if kind == h5l.TYPE_SOFT and _target(group, raw) == layout.link_target(where):
                continue  # a sensor's values
            if kind != h5l.TYPE_HARD:
                raise BadInputError(f"{path}: {where} is a link, which a session never holds.")
            item = h5o.open(group, raw)
            # A second name would be a second way to it, and with others of its kind countless.
            if (place := _place(item)) in seen:
                raise BadInputError(f"{path}: {where} is there under another name, too.")
            seen.add(place)
            if depth > _DEEPEST:
                raise BadInputError(f"{path}: {where} lies deeper than anything in a session.")
            if isinstance(item, h5g.GroupID):
                visit(item, where, depth + 1)
            elif isinstance(item, h5d.DatasetID):
                _check_dataset(item, where, path, size)
            else:
                raise BadInputError(f"{path}: {where} is of a kind that a session never holds.")

    try:
        visit(h5g.open(file.id, b"/"), "", 1)
    except (KeyError, ValueError) as error:  # names and types that make no sense
        raise OSError(str(error)) from None


def _place(item: Any) -> int:
    """Where in its file an object lies: the same by whichever name it is reached."""
    return int(h5o.get_info(item).addr)


def _target(group: Any, name: bytes) -> str:
    """Where a soft link leads."""
    return str(group.links.get_val(name).decode("utf-8", "surrogateescape"))


def _check_dataset(dataset: Any, where: str, path: Path, size: int) -> None:
    kind, made = dataset.dtype, dataset.get_create_plist()
    if kind.hasobject:
        raise BadInputError(f"{path}: {where} has a type that a session never holds.")
    if made.get_layout() == h5d.VIRTUAL or made.get_external_count():
        raise BadInputError(f"{path}: {where} lies in another file, which a session never does.")
    content = dataset.get_space().get_simple_extent_npoints() * kind.itemsize
    if content > _DENSEST * size + _SMALL_BYTES:
        raise BadInputError(f"{path}: {where} claims more content than the file can hold.")
