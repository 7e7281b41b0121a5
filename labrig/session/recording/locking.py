"""A lock on an open file that ends with its process, on Windows and elsewhere."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import BinaryIO

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


def is_locked(path: Path) -> bool:
    """Whether a living process holds the file at `path` locked."""
    try:
        with os.fdopen(os.open(path, os.O_RDWR | getattr(os, "O_BINARY", 0)), "r+b") as file:
            return not lock(file)
    except OSError:
        return False
