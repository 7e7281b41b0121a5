"""What the formats share: a file that must not be there yet."""

from __future__ import annotations

from pathlib import Path

from labrig.errors import BadInputError


def new_file(folder: Path, name: str) -> Path:
    """Return the path of a file to be written. Raises BadInputError when it is there already."""
    path = folder / name
    if path.exists():
        raise BadInputError(f"{path} exists already; choose another folder.")
    return path
