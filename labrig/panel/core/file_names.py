"""Names that pages may give to files: inside one folder, and nowhere else."""

from __future__ import annotations

import re
from pathlib import Path

from labrig.errors import BadInputError
from labrig.panel.errors import MissingError
from labrig.panel.job.registry import HIDDEN

_PART = re.compile(
    r"[^\W][\w .,+()=@-]{0,119}"
)  # no separators, no leading dot, no devices' colons
_DEVICES = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\..*)?")
_DEEPEST = 8


def inside(folder: Path, name: str, *suffixes: str) -> Path:
    """Return the path that a name stands for. Raises BadInputError for any that leads elsewhere."""
    parts = name.split("/")
    if len(name) > 400 or len(parts) > _DEEPEST or not all(map(_is_plain, parts)):
        raise BadInputError(f"{name[:80]!r} cannot be the name of a file here.")
    if suffixes and not name.lower().endswith(suffixes):
        raise BadInputError(f"{name[:80]!r}: the name must end in {' or '.join(suffixes)}.")
    path = folder.joinpath(*parts)
    # A link within the folder may lead out of it.
    if not path.resolve().is_relative_to(folder.resolve()):
        raise BadInputError(f"{name[:80]!r} does not lie in the data folder.")
    return path


def existing(folder: Path, name: str, *suffixes: str) -> Path:
    """Return the same, of a file that is there. Raises MissingError."""
    path = inside(folder, name, *suffixes)
    if not path.is_file():
        raise MissingError(f"{name}: there is no such file.")
    return path


def _is_plain(part: str) -> bool:
    if part == HIDDEN or part.endswith((" ", ".")) or _DEVICES.fullmatch(part):
        return False
    return _PART.fullmatch(part) is not None
