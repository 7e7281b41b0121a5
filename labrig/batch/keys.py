"""What decides whether a piece of work is done: the files' content, the options, the version."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from labrig.batch.contract import BatchInput, BatchItem, BatchTask
from labrig.serialise import finite

Stamp = tuple[tuple[int, int], ...]  # of each file: time of the last change in ns, size


def options_key(name: str, task: BatchTask, version: str) -> str:
    """Return the digest of a task's options and version; an option that is a file by content."""
    options = {}
    for one in fields(task):
        value = getattr(task, one.name)
        path = isinstance(value, Path) and value.is_file()
        options[one.name] = _of_file(value) if path else _plain(value)
    return digest({"task": name, "version": version, "options": options})


def piece_key(options: str, item: BatchItem) -> str:
    """Return the digest of all that decides a piece of work but the content of its files."""
    return digest({"options": options, "part": dict(item.part)})


def content_of(source: BatchInput) -> str:
    """Return the digest of the files of an input. Raises OSError."""
    return digest([_of_file(path) for path in source.files])


def stamp_of(source: BatchInput) -> Stamp:
    """Return what tells without reading whether files may have changed. Raises OSError."""
    states = [path.stat() for path in source.files]
    return tuple((state.st_mtime_ns, state.st_size) for state in states)


def digest(value: Any) -> str:
    """Return the SHA-256 of plain JSON, whichever order its keys are in."""
    text = json.dumps(finite(value), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def _of_file(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _plain(value: Any) -> Any:
    if isinstance(value, Path):
        return value.as_posix()
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    return list(value) if isinstance(value, tuple) else value
