"""Where a job can be found: a small file in the data folder, for its owner's eyes only."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from labrig.errors import BadInputError
from labrig.files import not_written
from labrig.serialise import from_json, to_json

HIDDEN = ".labrig"
GOING = "going"
ENDED = "ended"
LOST = "lost"
_TRIES = 20
_AGAIN_S = 0.05


@dataclass(frozen=True, kw_only=True)
class JobAddress:
    """A job, and how to connect to it. A client sends `key` first; nobody else knows it."""

    id: str
    kind: str  # run | preflight | weighing | camera
    by: str
    wall: str
    session: str | None  # the file's name within the data folder
    rig: str | None  # rig.toml's path
    pid: int
    port: int
    key: str
    state: str = GOING
    code: int | None = None
    text: str = ""

    def message(self) -> dict[str, Any]:
        """Return what pages may know of it."""
        shown = ("id", "kind", "state", "by", "wall", "session", "code", "text")
        return {"type": "job", **{name: getattr(self, name) for name in shown}}

    def ended(self, code: int | None, text: str, state: str = ENDED) -> JobAddress:
        """Return the same, over."""
        return replace(self, state=state, code=code, text=text)


def hidden_folder(data: Path) -> Path:
    """Return the panel's own folder within the data folder, made when it is not there."""
    folder = data / HIDDEN
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"{folder}: cannot be made ({error.strerror}).") from None
    return folder


def address_path(data: Path) -> Path:
    """Where the file is."""
    return data / HIDDEN / "job.json"


def write_address(data: Path, address: JobAddress) -> None:
    """Write it, whole or not at all; only its owner can read it."""
    hidden_folder(data)
    path = address_path(data)
    beside = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        with os.fdopen(os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w") as file:
            file.write(to_json(address))
        _put(beside, path)
    except OSError as error:
        raise not_written(path, error) from None


def _put(beside: Path, path: Path) -> None:
    """Windows does not replace a file while somebody reads it, which never lasts long."""
    for _ in range(_TRIES):
        try:
            beside.replace(path)
            return
        except PermissionError:
            threading.Event().wait(_AGAIN_S)
    beside.replace(path)


def read_address(data: Path) -> JobAddress | None:
    """Return the last job; None when there was none, or the file is no such file."""
    try:
        with address_path(data).open("rb") as file:
            return from_json(JobAddress, file.read(65536))
    except (OSError, ValueError):
        return None
