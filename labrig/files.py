"""Text files that appear whole or not at all, and why one could not be written."""

from __future__ import annotations

import errno
from pathlib import Path

from labrig.errors import BadInputError, LabrigError

# The disk's doing; else the path was none that can be written.
_OF_THE_DISK = frozenset({errno.ENOSPC, errno.EIO, getattr(errno, "EDQUOT", errno.ENOSPC)})


def write_text(path: Path, text: str) -> None:
    """Write a file beside its place and rename it. Raises what `not_written` makes of an error."""
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise not_written(path, error) from None


def not_written(path: Path, error: OSError) -> LabrigError:
    """The error to raise: a failure where the disk is full or broken, else a wrong path."""
    family = LabrigError if error.errno in _OF_THE_DISK else BadInputError
    why = "the disk is full" if error.errno == errno.ENOSPC else error.strerror
    return family(f"{path}: cannot be written ({why}).")
