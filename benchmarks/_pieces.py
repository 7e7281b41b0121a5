"""Pieces of a long benchmark, kept one by one: what was broken off is gone on with."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.report import RESULTS

_ROOT = Path(__file__).parents[1]
_CODE = ("protocols", "drivers", "model", "sim_hardware", "labrig/control", "labrig/experiment")
Piece = dict[str, Any]


class Pieces:
    """Results of the present code by name, in a file of a line each.

    `limit_s`: no piece is begun after so long.
    """

    def __init__(self, name: str, limit_s: float = float("inf"), folder: Path = RESULTS) -> None:
        self._path = folder / f"{name}.pieces.jsonl"
        self._until_s = time.monotonic() + limit_s
        self._known = self._read()

    def result(self, name: str, make: Callable[[], Piece]) -> Piece | None:
        """Return what is known of a piece, or make it; None: there is no time left for it."""
        if name not in self._known:
            if time.monotonic() > self._until_s:
                return None
            self._known[name] = made = make()
            self._path.parent.mkdir(exist_ok=True)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"code": code_digest(), "name": name, "piece": made}) + "\n")
        return self._known[name]

    def _read(self) -> dict[str, Piece]:
        if not self._path.exists():
            return {}
        found: dict[str, Piece] = {}
        for line in self._path.read_text(encoding="utf-8").splitlines():
            try:
                row = json.loads(line)
            except ValueError:  # the last line of a process that was killed
                continue
            if row["code"] == code_digest():
                found[row["name"]] = row["piece"]
        return found


@cache
def code_digest() -> str:
    """Return a digest of the code that has a say in the results."""
    digest = hashlib.sha256()
    for folder in _CODE:
        for path in sorted((_ROOT / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:10]
