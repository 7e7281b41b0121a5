"""Which sessions, in which order, page by page: all in SQL."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from labrig.errors import BadInputError
from labrig.library.database import NUMBER_COLUMNS, TEXT_COLUMNS
from labrig.library.entry import CatalogueEntry
from labrig.library.records import entry_of_row

COLUMNS = ("name", *TEXT_COLUMNS, *NUMBER_COLUMNS)


@dataclass(frozen=True, kw_only=True)
class Selection:
    """What is asked for. What a session does not have comes last, whichever way it is sorted.

    `text` is looked for in name, protocol, sheet, reason and fault, in what is stated of people and
    sample, and in the notes, without regard to capitals.
    """

    sort: str = "started"
    down: bool = True
    text: str = ""
    outcome: str = ""
    sheet: str = ""
    limit: int | None = None
    offset: int = 0

    def __post_init__(self) -> None:
        if self.sort not in COLUMNS:
            raise BadInputError(f"{self.sort!r} is no column; there are {', '.join(COLUMNS)}.")


@dataclass(frozen=True, kw_only=True)
class FoundSessions:
    """A page of sessions; `total` is how many fit."""

    entries: tuple[CatalogueEntry, ...]
    total: int


def select(connection: sqlite3.Connection, wanted: Selection) -> FoundSessions:
    """Return the page that is asked for."""
    where, values = _where(wanted)
    count = f"SELECT count(*) FROM sessions s {where}"  # noqa: S608 - names of columns are ours
    (total,) = connection.execute(count, values).fetchone()
    rows = _rows(connection, wanted, where, values)
    return FoundSessions(entries=tuple(map(entry_of_row, rows)), total=total)


def _rows(
    connection: sqlite3.Connection, wanted: Selection, where: str, values: list[Any]
) -> Iterator[tuple[str, str | None, int]]:
    """Yield first those that have what is sorted by, which an index has in order, then the rest."""
    left, skip = wanted.limit, wanted.offset
    joined = f"{where} AND" if where else "WHERE"
    way = "DESC" if wanted.down else "ASC"
    for there, order in (
        (f"s.{wanted.sort} IS NOT NULL", f"s.{wanted.sort} {way}, s.name {way}"),
        (f"s.{wanted.sort} IS NULL", "s.name"),
    ):
        if left == 0:
            return
        # The page is found by the small rows; then only its own entries are read.
        asked = connection.execute(
            f"SELECT e.entry, e.fit, e.outdated FROM (SELECT s.id, row_number() OVER () AS place"  # noqa: S608
            f" FROM (SELECT s.id FROM sessions s {joined} {there} ORDER BY {order}"
            f" LIMIT ? OFFSET ?) s) p JOIN entries e ON e.id = p.id ORDER BY p.place",
            [*values, -1 if left is None else left, skip],
        )
        count = 0
        for row in asked:
            count += 1
            yield row
        if left is not None:
            left -= count
        if skip and left != 0:
            count_of = f"SELECT count(*) FROM sessions s {joined} {there}"  # noqa: S608
            (known,) = connection.execute(count_of, values).fetchone()
            skip = max(0, skip - known)


def _where(wanted: Selection) -> tuple[str, list[Any]]:
    parts, values = list[str](), list[Any]()
    if wanted.outcome:
        parts.append("s.outcome = ?")
        values.append(wanted.outcome)
    if wanted.sheet:
        parts.append("s.id IN (SELECT id FROM sheets WHERE sheet = ?)")
        values.append(wanted.sheet)
    words = wanted.text.lower().split()
    if words:
        each = " AND ".join(["instr(words, ?)"] * len(words))
        parts.append(f"s.id IN (SELECT id FROM texts WHERE {each})")  # noqa: S608
        values += words
    return (f"WHERE {' AND '.join(parts)}" if parts else ""), values
