"""Files that are on the disk when we say so, and that appear whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from labrig.errors import BadInputError


def sync_file(path: Path) -> None:
    """Wait until the disk has a file's content."""
    with path.open("r+b") as file:
        os.fsync(file.fileno())


def sync_folder(path: Path) -> None:
    """Wait until the disk knows the names in a folder, where the system can be asked for it."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:  # Windows opens no folders, and needs no such thing
        return
    try:
        os.fsync(descriptor)
    except OSError:
        pass
    finally:
        os.close(descriptor)


@contextmanager
def written_beside(path: Path) -> Iterator[Path]:
    """A name beside `path` to write to; it takes the place of `path` when all went well."""
    beside = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        yield beside
        sync_file(beside)
        try:
            beside.replace(path)
        except PermissionError:
            raise BadInputError(
                f"{path} cannot be replaced; close the program that has it open, then try again."
            ) from None
        sync_folder(path.parent)
    finally:
        beside.unlink(missing_ok=True)
