"""Files that are on the disk when we say so, and that appear whole or not at all."""

from __future__ import annotations

import errno
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from labrig.errors import BadInputError, ExitCode
from labrig.files import discard, family_of


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


def cause(error: Exception) -> str:
    """Return what the system said, in words."""
    number = error.errno if isinstance(error, OSError) else None
    if number is None:
        # The HDF5 library hands the system's error on as text.
        said = re.search(r"errno = (\d+)", str(error))
        number = int(said.group(1)) if said else None
    if number == errno.ENOSPC:
        return "the disk is full"
    if number is not None:
        return os.strerror(number)
    return str(error) or type(error).__name__


def is_of_writing(error: Exception) -> bool:
    """Whether the HDF5 library could not write; it has several kinds of errors for that."""
    return "file write failed" in str(error) or "write request failed" in str(error)


_failed_writes = 0


def note_a_failed_write() -> None:
    """React to a disk that takes no more: see `end_before_the_library_does`."""
    global _failed_writes
    _failed_writes += 1


_left_behind = False


def note_a_device_left_behind() -> None:
    """React to a thread that is still in a device's code: see `end_before_the_library_does`."""
    global _left_behind
    _left_behind = True


def end_before_the_library_does(code: int) -> None:
    """End the process at once where a library would not end well.

    The HDF5 library, where it could not write something, would try once more at its own end, and
    crash. Where the output is not known to be safe, gRPC would wait for boards that do not answer:
    whoever waits for the exit code has to act now. A thread that a device's library does not let
    go of would make Python abort. Everything else has ended by now, and what is to be recovered
    lies in the journal. Else nothing happens.
    """
    if not _failed_writes and not _left_behind and code != ExitCode.OUTPUT_UNKNOWN:
        return
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


@contextmanager
def written_beside(path: Path) -> Iterator[Path]:
    """Yield a name beside `path` to write to; it takes the place of `path` when all went well.

    Raises LabrigError when the disk does not take it, BadInputError when nothing can be written
    there; `path` is then as it was.
    """
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
    except (OSError, RuntimeError) as error:
        if is_of_writing(error):
            note_a_failed_write()
        elif isinstance(error, RuntimeError):
            raise
        raise family_of(error)(f"{path} cannot be written: {cause(error)}.") from error
    finally:
        discard(beside)
