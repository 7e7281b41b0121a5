"""Results of sessions, computed once in a process of its own and kept beside the sessions.

Each is kept by the state of the files it was made from; a change of any of them makes it invalid.
"""

from __future__ import annotations

import hashlib
import json
import os
import threading
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from labrig.errors import LabrigError
from labrig.files import write_text
from labrig.panel.job.registry import HIDDEN
from labrig.panel.pages._result_data import BESIDE, beside, complete_result, fitted_result

Compute = Callable[[Path, str, str], str]
VERSION = 1  # of what is kept
NICE = 10  # a run comes first


class ResultCache:
    """Results of one panel's sessions, as JSON texts."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._known: dict[str, tuple[str, str]] = {}  # path -> state, text
        self._under_way: dict[tuple[str, str, str], Future[str]] = {}
        self._pool: ProcessPoolExecutor | None = None

    def kept(self, data: Path, path: Path) -> str | None:
        """Return the result of a session as it is now, where it was computed before."""
        state = state_of(path)
        with self._lock:
            known = self._known.get(str(path))
        if known is None:
            known = _read(_file(data, path))
        if known is None or known[0] != state:
            return None
        with self._lock:
            self._known[str(path)] = known
        return known[1]

    def fitted(self, path: Path, name: str) -> str:
        """Return the result of a session with its models, but not yet how B and EIBM settled."""
        return self._asked(_compute_fitted, path, name, state_of(path))

    def computed(self, data: Path, path: Path, name: str) -> str:
        """Return the whole result of a session, and keep it. Blocks."""
        state = state_of(path)
        text = self._asked(_compute, path, name, state)
        with self._lock:
            self._known[str(path)] = (state, text)
        _write(_file(data, path), state, text)
        return text

    def _asked(self, compute: Compute, path: Path, name: str, state: str) -> str:
        """Return what the process computes; two who ask for the same share it."""
        key = (compute.__name__, str(path), state)
        with self._lock:
            future = self._under_way.get(key)
            if future is None:
                future = self._under_way[key] = self._started().submit(compute, path, name, state)
        try:
            return future.result()
        finally:
            with self._lock:
                self._under_way.pop(key, None)

    def _started(self) -> ProcessPoolExecutor:
        if self._pool is None:
            self._pool = ProcessPoolExecutor(1, get_context("spawn"), initializer=_be_nice)
        return self._pool


def state_of(path: Path) -> str:
    """Return times and sizes of a session and of the files beside it."""
    parts = [str(VERSION)]
    for file in (path, *(beside(path, suffix) for suffix in BESIDE)):
        try:
            found = file.stat()
            parts.append(f"{found.st_mtime_ns},{found.st_size}")
        except OSError:
            parts.append("-")
    return ";".join(parts)


def _compute(path: Path, name: str, state: str) -> str:
    return json.dumps({**complete_result(path, name, state), "complete": True}, allow_nan=False)


def _compute_fitted(path: Path, name: str, state: str) -> str:
    _, found = fitted_result(path, name, state)
    return as_text(found)


def _be_nice() -> None:
    if hasattr(os, "nice"):
        os.nice(NICE)


def _file(data: Path, path: Path) -> Path:
    name = hashlib.sha256(str(path).encode()).hexdigest()[:16]
    return data / HIDDEN / "results" / f"{path.stem}-{name}.json"


def _read(file: Path) -> tuple[str, str] | None:
    try:
        state, text = file.read_text(encoding="utf-8").split("\n", 1)
    except (OSError, ValueError):
        return None
    return state, text


def _write(file: Path, state: str, text: str) -> None:
    """Keep a result; where that cannot be done it is computed again next time."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_text(file, f"{state}\n{text}")
    except (OSError, LabrigError):
        return


def as_text(found: dict[str, Any]) -> str:
    """Return a result that was not computed whole, as JSON."""
    return json.dumps({**found, "complete": False}, allow_nan=False)
