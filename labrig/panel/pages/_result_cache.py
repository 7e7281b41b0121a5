"""Results of sessions, computed once in a process of its own and kept beside the sessions.

Each is kept by the state of the files it was made from; a change of any of them makes it invalid.
"""

from __future__ import annotations

import hashlib
import json
import threading
from pathlib import Path
from typing import Any

from labrig.errors import LabrigError
from labrig.files import write_text
from labrig.panel.job.registry import HIDDEN
from labrig.panel.pages._result_data import BESIDE, beside
from labrig.panel.pages._result_process import ResultProcess

VERSION = 2  # of what is kept


class ResultCache:
    """Results of one panel's sessions, as JSON texts."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._known: dict[str, tuple[str, str]] = {}  # path -> state, text
        self._process = ResultProcess()

    def close(self) -> None:
        """End what is computed now: the panel ends."""
        self._process.close()

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

    def prepare(self) -> None:
        """Start the process that computes, so that it has loaded what it needs when asked."""
        self._process.prepare()

    def fitted(self, path: Path, name: str) -> str:
        """Return the result of a session with its models, but not yet how B and EIBM settled."""
        return as_text(self._process.ask("fitted", path, name, state_of(path)))

    def settling(self, data: Path, path: Path, name: str) -> str:
        """Return B and EIBM as positions are added, as far as half a second of computing gets."""
        found = self._process.ask("settling", path, name, state_of(path))
        if found["complete"]:
            self.computed(data, path, name)
        return json.dumps(found, allow_nan=False)

    def computed(self, data: Path, path: Path, name: str) -> str:
        """Return the whole result of a session, and keep it. Blocks."""
        state = state_of(path)
        text = json.dumps(self._process.ask("whole", path, name, state), allow_nan=False)
        with self._lock:
            self._known[str(path)] = (state, text)
        _write(_file(data, path), state, text)
        return text


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
