"""The token of a data folder's panel: kept, so that open pages find a panel that is started again.

It lies beside the job's own key, for the owner's eyes only.
"""

from __future__ import annotations

import os
import re
import secrets
import stat
from pathlib import Path

from labrig.errors import LabrigError
from labrig.files import not_written
from labrig.panel.job.registry import hidden_folder

_NAME = "token"
_TOKEN = re.compile(r"[A-Za-z0-9_-]{32,64}")
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


def kept_token(data: Path) -> str:
    """Return the token of this folder's last panel, or a new one, kept where that is possible."""
    found = _read(hidden_folder(data) / _NAME)
    if found is not None:
        return found
    try:
        return new_token(data)
    except LabrigError:  # a folder of sessions that can only be read
        return secrets.token_urlsafe(24)


def new_token(data: Path) -> str:
    """Return a new token and keep it: pages with an earlier one are no longer let in.

    Raises LabrigError when it cannot be kept.
    """
    path, token = hidden_folder(data) / _NAME, secrets.token_urlsafe(24)
    beside = path.with_name(f"{_NAME}.{os.getpid()}.new")
    try:
        beside.unlink(missing_ok=True)
        with os.fdopen(os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(token)
        beside.replace(path)
    except OSError as error:
        raise not_written(path, error) from None
    return token


def _read(path: Path) -> str | None:
    """Return what is kept; None where somebody else can read it or it is no token."""
    try:
        with path.open("rb") as file:
            if os.name == "posix" and os.fstat(file.fileno()).st_mode & _OTHERS:
                return None
            found = file.read(128).decode("ascii", "replace")
    except OSError:
        return None
    return found if _TOKEN.fullmatch(found) else None
