"""The rows of a batch: one line of JSON for each piece of work as it ends, in a file that grows.

A row counts when its line is complete and on the disk. What a crash has left of the last line is
cut off when the batch goes on. Of several rows of one piece the last one counts.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

from labrig.files import as_text
from labrig.serialise import finite

VERSION = 1


class PieceOutcome(StrEnum):
    """How a piece of work ended."""

    DONE = "done"
    FAULT = "fault"  # the input, or the task, is at fault
    LOST = "lost"  # its worker was killed, each time; the same command does it again


@dataclass(frozen=True, kw_only=True)
class Row:
    """One piece of work that has ended."""

    name: str
    key: str  # of options, version and part
    outcome: PieceOutcome
    content: str = ""  # digest of the files, as the work left them
    stamp: tuple[tuple[int, int], ...] = ()  # of the same
    sentence: str = ""  # why there is no result
    digest: str = ""  # of the whole result
    columns: dict[str, Any] = field(default_factory=dict)
    attempts: int = 1
    cpu_s: float = 0.0
    wall_s: float = 0.0
    ended: str = ""  # UTC

    def line(self) -> bytes:
        """Return the line of the file."""
        plain = {"version": VERSION, **finite(vars(self)), "outcome": self.outcome.value}
        letters = as_text(self.name) == self.name  # else its bytes stand there as numbers
        text = json.dumps(plain, ensure_ascii=not letters, allow_nan=False)
        return as_text(text).encode("utf-8") + b"\n"


def row_of(line: bytes) -> Row | None:
    """Return the row of a line; None where it is damaged or of another version."""
    try:
        plain = json.loads(line)
        if plain.pop("version") != VERSION:
            return None
        stamp = tuple((int(a), int(b)) for a, b in plain.pop("stamp"))
        outcome = PieceOutcome(plain.pop("outcome"))
        row = Row(stamp=stamp, outcome=outcome, **plain)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None
    return row if isinstance(row.columns, dict) and isinstance(row.name, str) else None


def rows_in(path: Path) -> Iterator[Row]:
    """Yield the rows of a file in their order; damaged lines are passed over."""
    try:
        file = path.open("rb")
    except FileNotFoundError:
        return
    with file:
        for line in file:
            if line.endswith(b"\n") and (row := row_of(line)) is not None:
                yield row


class LastRows:
    """The last row of each of these names, in their order; of the rows only places are kept."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        self._path, self._names = path, names
        self._places: dict[str, int] = {}
        wanted, at = set(names), 0
        with suppress(FileNotFoundError), path.open("rb") as file:
            for line in file:
                row = row_of(line) if line.endswith(b"\n") else None
                if row is not None and row.name in wanted:
                    self._places[row.name] = at
                at += len(line)

    def __len__(self) -> int:
        """Return how many of the names have a row."""
        return len(self._places)

    def __iter__(self) -> Iterator[Row]:
        """Yield them, as often as wanted."""
        if not self._places:
            return
        with self._path.open("rb") as file:
            for name in self._names:
                if name in self._places:
                    file.seek(self._places[name])
                    row = row_of(file.readline())
                    if row is not None:
                        yield row
