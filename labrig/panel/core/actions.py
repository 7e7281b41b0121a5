"""What was done at panels of this data folder: who, what, when. Only ever appended to."""

from __future__ import annotations

import json
import threading
from pathlib import Path

from labrig.errors import BadInputError
from labrig.panel.core.control import utc_now
from labrig.panel.job.registry import hidden_folder

_TAIL_BYTES = 256 << 10


class Actions:
    """`.labrig/actions.jsonl` of the data folder."""

    def __init__(self, data: Path) -> None:
        self._path = hidden_folder(data) / "actions.jsonl"
        self._lock = threading.Lock()

    def add(self, who: str, what: str) -> None:
        """One more. Raises BadInputError when it cannot be written down."""
        line = json.dumps({"wall": utc_now(), "who": who, "what": what}) + "\n"
        try:
            with self._lock, self._path.open("a", encoding="utf-8") as file:
                file.write(line)
        except OSError as error:
            raise BadInputError(f"{self._path}: cannot be written ({error.strerror}).") from None

    def last(self, count: int) -> list[dict[str, str]]:
        """Return the newest ones, newest last."""
        try:
            with self._path.open("rb") as file:
                file.seek(max(0, self._path.stat().st_size - _TAIL_BYTES))
                lines = file.read().decode("utf-8", "replace").splitlines()
        except OSError:
            return []
        return [found for line in lines[-count:] if (found := _parsed(line)) is not None]


def _parsed(line: str) -> dict[str, str] | None:
    try:
        found = json.loads(line)
    except ValueError:  # the first one of the tail may be half a line
        return None
    return found if isinstance(found, dict) else None
