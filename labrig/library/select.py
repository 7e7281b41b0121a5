"""Which sessions, in which order, page by page: all in SQL."""

from __future__ import annotations

import difflib
import json
import sqlite3
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

from labrig.errors import BadInputError
from labrig.library.database import NUMBER_COLUMNS, TEXT_COLUMNS
from labrig.library.entry import CatalogueEntry
from labrig.library.records import entry_of_row

_FEW = 10_000  # sessions that are sorted quickly
COLUMNS = ("name", *TEXT_COLUMNS, *NUMBER_COLUMNS)


@dataclass(frozen=True, kw_only=True)
class SessionQuery:
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
            close = difflib.get_close_matches(self.sort, COLUMNS, n=1)
            hint = f"did you mean {close[0]}" if close else "started, name and B_Nm2 are some"
            raise BadInputError(f"--sort {self.sort}: there is no such column; {hint}.")


@dataclass(frozen=True, kw_only=True)
class FoundSessions:
    """A page of sessions; `total` is how many fit."""

    entries: tuple[CatalogueEntry, ...]
    total: int


def select(connection: sqlite3.Connection, wanted: SessionQuery) -> FoundSessions:
    """Return the page that is asked for."""
    fitting = _fitting(connection, wanted)
    if fitting is None:
        (total,) = connection.execute("SELECT count(*) FROM sessions").fetchone()
    else:
        total = len(fitting)
    page = list(islice(_ordered(connection, wanted, fitting), wanted.limit))
    rows = _rows(connection, page)
    return FoundSessions(entries=tuple(entry_of_row(rows[one]) for one in page), total=total)


def _fitting(connection: sqlite3.Connection, wanted: SessionQuery) -> set[int] | None:
    """Return the ids of sessions that fit; None where all do. Each table is gone through once."""
    asked = list[tuple[str, list[str]]]()
    if wanted.outcome:
        asked.append(("sessions WHERE outcome = ?", [wanted.outcome]))
    if wanted.sheet:
        asked.append(("sheets WHERE sheet = ?", [wanted.sheet]))
    words = wanted.text.lower().split()
    if words:  # last, since it takes longest: among few sessions it is quick
        asked.append((f"texts WHERE {' AND '.join(['instr(words, ?)'] * len(words))}", words))
    found: list[int] | None = None
    for where, values in asked:
        among, few = "", found is not None and len(found) <= _FEW
        if few:
            among, values = (
                " AND id IN (SELECT value FROM json_each(?))",
                [*values, json.dumps(found)],
            )
        # As one text: to fetch a hundred thousand rows takes Python longer than to find them.
        text = f"SELECT json_group_array(id) FROM {where}{among}"  # noqa: S608 - constants
        (new,) = connection.execute(text, values).fetchone()
        ids: list[int] = json.loads(new)
        found = ids if few or found is None else list(set(found).intersection(ids))
    return None if found is None else set(found)


def _ordered(
    connection: sqlite3.Connection, wanted: SessionQuery, fitting: set[int] | None
) -> Iterator[int]:
    """Yield ids from the first that is wanted on: those that have what is sorted by, then others.

    An index has them in order. Where few fit, only these are sorted.
    """
    skip = wanted.offset
    few = fitting is not None and len(fitting) <= _FEW
    among = " AND id IN (SELECT value FROM json_each(?))" if few else ""
    values = [json.dumps(sorted(fitting or ()))] if few else []
    column, way = wanted.sort, "DESC" if wanted.down else "ASC"
    plus = "+" if few else ""  # no index then
    for there, order in (
        (f"{column} IS NOT NULL", f"{plus}{column} {way}, name {way}"),
        (f"{column} IS NULL", f"{plus}name"),
    ):
        # Names of columns are ours.
        text = f"SELECT id FROM sessions WHERE {there}{among} ORDER BY {order}"  # noqa: S608
        if wanted.limit is not None and (few or fitting is None):
            text += f" LIMIT {wanted.limit + skip}"  # what is sorted need not be kept
        for (number,) in connection.execute(text, values):
            if fitting is not None and number not in fitting:
                continue
            if skip:
                skip -= 1
                continue
            yield number


def _rows(
    connection: sqlite3.Connection, ids: Sequence[int]
) -> dict[int, tuple[str, str | None, int]]:
    asked = connection.execute(
        "SELECT id, entry, fit, outdated FROM entries WHERE id IN (SELECT value FROM json_each(?))",
        (json.dumps(ids),),
    )
    return {number: (entry, fit, outdated) for number, entry, fit, outdated in asked}
