"""A lock on an open file that ends with its process, on Windows and elsewhere."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from labrig.errors import BadInputError, ReadOnlyError

# Far behind any content: Windows refuses others to read the bytes that are locked.
_WHERE = 1 << 62


def lock(file: BinaryIO) -> bool:
    """Lock an open file for this process; False when another process has it."""
    try:
        if sys.platform == "win32":
            import msvcrt

            position = file.tell()
            try:
                file.seek(_WHERE)
                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            finally:
                file.seek(position)
        else:
            import fcntl

            fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def unlock(file: BinaryIO) -> None:
    """Give the lock back; closing the file, or the end of the process, does it too."""
    if sys.platform == "win32":
        import msvcrt

        position = file.tell()
        try:
            file.seek(_WHERE)
            msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)
        except OSError:
            pass
        finally:
            file.seek(position)


@contextmanager
def only_writer(path: Path, patience_s: float = 60.0) -> Iterator[None]:
    """Let one program at a time replace the file at `path`; others wait for it.

    A file beside it is locked meanwhile. Raises BadInputError when another program does not end.
    """
    beside = path.with_name(f"{path.name}.lock")
    with locked_file(beside, patience_s, of=path):
        try:
            yield
        finally:
            with suppress(OSError):  # Windows removes no file that somebody has open
                beside.unlink()


@contextmanager
def locked_file(path: Path, patience_s: float, of: Path | None = None) -> Iterator[BinaryIO]:
    """Yield the file at `path` open and locked; it is made where there is none.

    Whoever has it locked may delete it. Raises BadInputError when it cannot be used, or when
    another program does not let go of it; `of` is the file that it is the lock of.
    """
    give_up_s = time.monotonic() + patience_s
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0)
    while True:
        try:
            file = os.fdopen(os.open(path, flags, 0o666), "r+b", buffering=0)
        except OSError as error:
            raise ReadOnlyError(_cannot_write(path, of, error)) from None
        with file:
            if lock(file) and _is_at(file, path):
                try:
                    yield file
                finally:
                    unlock(file)
                return
        if time.monotonic() > give_up_s:
            name = of or path
            raise BadInputError(f"{name}: another program is writing to it; try again later.")
        threading.Event().wait(0.02)


def _cannot_write(path: Path, of: Path | None, error: OSError) -> str:
    if of is None:
        return f"{path} cannot be written: {error.strerror}."
    return (
        f"{of} cannot be changed: {path.name} beside it, a file which keeps other programs from it "
        f"meanwhile, cannot be written ({error.strerror})."
    )


def _is_at(file: BinaryIO, path: Path) -> bool:
    """Whether an open file is still the one at its path: whoever had it may have removed it."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except OSError:
        return False


def is_locked(path: Path) -> bool:
    """Whether a living process holds the file at `path` locked."""
    try:
        with os.fdopen(os.open(path, os.O_RDWR | getattr(os, "O_BINARY", 0)), "r+b") as file:
            return not lock(file)
    except OSError:
        return False
