"""The SQLite file that a catalogue is kept in: a cache, which may be thrown away at any time.

There is one for each folder of sessions and computer: users may have their cache folder on a share,
and SQLite's log of writes works between the processes of one computer only. One that is damaged is
made anew; where none can be made, the catalogue is in memory.
"""

from __future__ import annotations

import hashlib
import os
import platform
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from labrig.library.cache_folder import cache_folder

VERSION = 3  # of tables, what is read, and which fit is chosen; each version has a file of its own
PATIENCE_S = 60.0  # for other programs that write
_AGAIN_S = 0.02
MEMORY = ":memory:"
T = TypeVar("T")

# What is sorted by, and may be missing, is NULL where it is.
TEXT_COLUMNS = ("started", "sheet", "protocol", "title", "project", "sample", "outcome")
NUMBER_COLUMNS = (
    "runs", "runs_complete", "readings", "invalid", "bytes", "duration_s", "largest_force_mN",
    "scatter_mN", "B_Nm2", "E_Pa", "EIBM_Nm", "rmse_force_mN", "rmse_curve_mm",
)  # fmt: skip
_INDEXED = ("started", "outcome", "B_Nm2", "EIBM_Nm", "largest_force_mN")
_SCHEMA = f"""
CREATE TABLE about (folder TEXT NOT NULL);
CREATE TABLE files (name TEXT PRIMARY KEY, changed INTEGER NOT NULL, size INTEGER NOT NULL)
    WITHOUT ROWID;
CREATE TABLE sessions (
    id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, damaged INTEGER NOT NULL,
    {", ".join(f"{name} TEXT" for name in TEXT_COLUMNS)},
    {", ".join(f"{name} REAL" for name in NUMBER_COLUMNS)}
);
{"".join(f"CREATE INDEX by_{name} ON sessions ({name}, name);" for name in _INDEXED)}
CREATE INDEX by_damage ON sessions (damaged) WHERE damaged;
CREATE TABLE entries (id INTEGER PRIMARY KEY, entry TEXT NOT NULL, fit TEXT, outdated INTEGER);
CREATE TABLE texts (id INTEGER PRIMARY KEY, words TEXT NOT NULL);
CREATE TABLE sheets (sheet TEXT NOT NULL, id INTEGER NOT NULL, PRIMARY KEY (sheet, id))
    WITHOUT ROWID;
CREATE TABLE data (checksum TEXT NOT NULL, id INTEGER NOT NULL, PRIMARY KEY (checksum, id))
    WITHOUT ROWID;
CREATE INDEX data_of ON data (id);
CREATE TABLE models (name TEXT PRIMARY KEY, checksum TEXT NOT NULL, changed INTEGER NOT NULL,
    kind TEXT NOT NULL, fits TEXT NOT NULL);
CREATE INDEX models_of ON models (checksum);
"""


def database_path(folder: Path) -> Path:
    """Return where the catalogue of a folder is kept."""
    what = f"{platform.node()}\n{os.path.normcase(folder.resolve())}"
    name = hashlib.sha256(what.encode("utf-8", "surrogateescape")).hexdigest()[:20]
    return cache_folder() / "catalogue" / f"{name}-{VERSION}.sqlite"


class Database:
    """One connection, used by one thread at a time."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.path: Path | None = database_path(folder)
        self.generation = 0  # grows when what was known is lost
        self._lock = threading.RLock()
        self._connection = self._opened()

    def close(self) -> None:
        """Let go of the file."""
        with self._lock:
            self._connection.close()

    def read(self, ask: Callable[[sqlite3.Connection], T]) -> T:
        """Return what `ask` finds; it may be called twice."""
        with self._lock:
            return self._healed(lambda: ask(self._connection))

    def write(self, change: Callable[[sqlite3.Connection], T]) -> T:
        """Do all of a change or nothing of it; other programs wait. It may be called twice."""
        with self._lock:
            return self._healed(lambda: self._changed(change))

    def _changed(self, change: Callable[[sqlite3.Connection], T]) -> T:
        with _transaction(self._connection):
            return change(self._connection)

    def _healed(self, do: Callable[[], T]) -> T:
        """Do it; where the file is of no use, begin with an empty one and do it again."""
        try:
            return do()
        except (sqlite3.ProgrammingError, sqlite3.IntegrityError):
            raise  # a mistake of labrig's
        except (sqlite3.DatabaseError, ValueError, TypeError, KeyError) as error:
            damaged = _is_damage(error)
        self._connection.close()
        if damaged:
            self._discard()
        else:  # the disk is full, say
            self.path = None
        self._connection = self._opened()
        self.generation += 1
        return do()

    def _opened(self) -> sqlite3.Connection:
        give_up_s = time.monotonic() + PATIENCE_S
        discarded = False
        while self.path is not None and time.monotonic() < give_up_s:
            try:
                return self._connected(self.path)
            except (sqlite3.DatabaseError, OSError) as error:
                if "locked" in str(error):  # the log of writes is begun without any patience
                    threading.Event().wait(_AGAIN_S)
                    continue
                if discarded or not _is_damage(error):
                    break
            self._discard()
            discarded = True
        # A cache that cannot be written, or be deleted while another program has it open.
        self.path = None
        return self._connected(None)

    def _connected(self, path: Path | None) -> sqlite3.Connection:
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
        connection = sqlite3.connect(
            MEMORY if path is None else path, timeout=PATIENCE_S, isolation_level=None,
            check_same_thread=False,
        )  # fmt: skip
        try:
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA synchronous = OFF")  # a crash costs the cache, no more
            with _transaction(connection):
                self._prepare(connection)
        except BaseException:
            connection.close()
            raise
        return connection

    def _prepare(self, connection: sqlite3.Connection) -> None:
        if connection.execute("PRAGMA user_version").fetchone() == (VERSION,):
            return
        for statement in _SCHEMA.split(";"):
            if statement.strip():
                connection.execute(statement)
        connection.execute("INSERT INTO about VALUES (?)", (str(self._folder),))
        connection.execute(f"PRAGMA user_version = {VERSION}")

    def _discard(self) -> None:
        if self.path is None:
            return
        for ending in ("", "-wal", "-shm"):
            with suppress(OSError):
                self.path.with_name(self.path.name + ending).unlink(missing_ok=True)


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Iterator[None]:
    """Take the right to write at once: to ask for it later fails where others have it."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        yield
    except BaseException:
        with suppress(sqlite3.Error):
            connection.execute("ROLLBACK")
        raise
    connection.execute("COMMIT")


def _is_damage(error: Exception) -> bool:
    """Whether an error says that the file is damaged, rather than that it cannot be written."""
    if isinstance(error, OSError):
        return False
    if not isinstance(error, sqlite3.OperationalError):
        return True
    text = str(error)
    return any(word in text for word in ("no such", "has no column", "malformed", "disk I/O error"))
