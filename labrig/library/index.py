"""The sessions of a folder, looked up again only where a file has changed."""

from __future__ import annotations

import os
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

from labrig.errors import BadInputError
from labrig.files import SESSION_ENDINGS, check_is_text
from labrig.library.database import Database
from labrig.library.entry import CatalogueEntry, read_entry
from labrig.library.fits import ModelFits, looks_like_model, read_fits
from labrig.library.records import choose_fits, entry_of_row, forget, put_entry, put_model
from labrig.library.select import FoundSessions, SessionQuery, select
from labrig.progress import Progress

MOST_FILES = 1_000_000
MOST_MODEL_BYTES = 1 << 20
_SAVE_EVERY_S = 2.0
_MOST_UNSAVED = 500
_LONG_SCAN_S = 0.05  # a folder that takes longer is not gone through at each request
_SCAN_SHARE = 0.1  # of the time at most, where somebody asks again and again
_SUFFIXES = (*SESSION_ENDINGS, ".toml")

Stamp = tuple[int, int]  # time of the last change in ns, size
T = TypeVar("T")
Looked = tuple[str, Stamp, CatalogueEntry | None, ModelFits | None]


class Library:
    """One folder and all below it. May be asked from several threads and programs."""

    def __init__(self, folder: Path) -> None:
        """Look into the folder; raise BadInputError when there is none."""
        if not folder.is_dir():
            if folder.exists():
                raise BadInputError(f"{folder}: this is a file, a folder is needed.")
            raise BadInputError(f"{folder}: there is no such folder.")
        self.folder = folder
        self.cut = ""  # a sentence, where the folder has more files than are listed
        self._database = Database(folder)
        self._refreshing = threading.Lock()
        self._scanned_s, self._scan_s, self._pending = float("-inf"), 0.0, 0

    @property
    def cache(self) -> Path | None:
        """The file in which it keeps what it knows; None where that is in memory."""
        return self._database.path

    def close(self) -> None:
        """Let go of the cache."""
        self._database.close()

    def refresh(self, budget_s: float | None = None, advance: Progress | None = None) -> int:
        """Look at what has changed; the number of files that are left when the time is over.

        With a budget a folder that takes long to go through is gone through now and then only.
        """
        with self._refreshing:
            if budget_s is not None and self._just_scanned():
                return 0
            before = self._database.generation
            self._pending = self._refresh(budget_s, advance)
            if self._database.generation != before:  # what was known before is to be found again
                self._pending = self._refresh(budget_s, advance)
            return self._pending

    def find(self, wanted: SessionQuery) -> FoundSessions:
        """Return the sessions that fit, as they were at the last `refresh`, with their fits."""
        return self._asked(lambda connection: select(connection, wanted))

    def entries(self) -> list[CatalogueEntry]:
        """Return all sessions, in the order of their names."""
        return list(self.find(SessionQuery(sort="name", down=False)).entries)

    def entry(self, name: str) -> CatalogueEntry | None:
        """Return the session of this name, if it is known."""
        row = self._asked(
            lambda connection: connection.execute(
                "SELECT e.entry, e.fit, e.outdated FROM sessions s JOIN entries e ON e.id = s.id"
                " WHERE s.name = ?",
                (name,),
            ).fetchone()
        )
        return None if row is None else entry_of_row(row)

    def damaged(self) -> int:
        """Return how many sessions cannot be read."""
        ask = "SELECT count(*) FROM sessions WHERE damaged"
        return int(self._asked(lambda connection: connection.execute(ask).fetchone()[0]))

    def _asked(self, ask: Callable[[sqlite3.Connection], T]) -> T:
        """Ask; where the cache turns out to be damaged, look at all files again first."""
        before = self._database.generation
        found = self._database.read(ask)
        if self._database.generation == before:
            return found
        self.refresh()
        return self._database.read(ask)

    def _just_scanned(self) -> bool:
        if self._pending or self._scan_s < _LONG_SCAN_S:
            return False
        return time.monotonic() - self._scanned_s < self._scan_s / _SCAN_SHARE

    def _refresh(self, budget_s: float | None, advance: Progress | None) -> int:
        began_s = time.monotonic()
        end_s = None if budget_s is None else began_s + budget_s
        there = dict(self._files())
        known = self._known()
        changed = [name for name, stamp in there.items() if known.get(name) != stamp]
        gone = known.keys() - there.keys()
        self._scanned_s = time.monotonic()
        self._scan_s = self._scanned_s - began_s
        if gone:
            self._database.write(lambda connection: _forget_all(connection, gone))
        looked = list[Looked]()
        saved_s = time.monotonic()
        for count, name in enumerate(changed):
            # One at least, or a slow disk would keep whoever asks again and again waiting for ever.
            if count and end_s is not None and time.monotonic() > end_s:
                self._save(looked)
                return len(changed) - count
            if count % _MOST_UNSAVED == 0 and count:  # other programs may have looked, too
                known = self._known(changed[count : count + _MOST_UNSAVED])
            if known.get(name) != there[name]:
                looked.append(_look(self.folder / name, name, there[name]))
            if advance is not None:
                advance((count + 1) / len(changed), name)
            if len(looked) >= _MOST_UNSAVED or time.monotonic() - saved_s > _SAVE_EVERY_S:
                self._save(looked)
                saved_s = time.monotonic()
        self._save(looked)
        return 0

    def _known(self, names: Sequence[str] | None = None) -> dict[str, Stamp]:
        """Return the stamps of what was looked into, of all files or of some."""
        ask, values = "SELECT name, changed, size FROM files", tuple(names or ())
        if names is not None:
            ask += f" WHERE name IN ({', '.join('?' * len(names))})"
        rows = self._database.read(lambda connection: connection.execute(ask, values).fetchall())
        return {name: (changed, size) for name, changed, size in rows}

    def _save(self, looked: list[Looked]) -> None:
        """Store what was found, in one piece, and forget that it is to be stored."""
        if looked:
            self._database.write(lambda connection: _put_all(connection, looked))
            looked.clear()

    def _files(self) -> Iterator[tuple[str, Stamp]]:
        """Sessions and models, by name; hidden folders and links to folders are left out."""
        self.cut = ""
        for count, one in enumerate(_files(self.folder)):
            try:
                check_is_text(Path(one[0]))
            except BadInputError as error:  # the database holds texts alone
                self.cut = f"not listed: {error}"
                continue
            if count >= MOST_FILES:
                self.cut = (
                    f"{self.folder}: only the first {MOST_FILES} sessions and models are listed;"
                    " list a folder in it."
                )
                return
            yield one


def _put_all(connection: sqlite3.Connection, looked: Sequence[Looked]) -> None:
    ids, checksums = set[int](), set[str]()
    for name, stamp, entry, fits in looked:
        if name.endswith(".toml"):
            checksums |= forget(connection, name)
        if entry is not None:
            ids.add(put_entry(connection, entry))
        if fits is not None:
            put_model(connection, name, stamp[0], fits)
            checksums.add(fits.checksum)
        connection.execute("INSERT OR REPLACE INTO files VALUES (?, ?, ?)", (name, *stamp))
    choose_fits(connection, ids, checksums)


def _forget_all(connection: sqlite3.Connection, names: set[str]) -> None:
    checksums = set[str]()
    for name in names:
        checksums |= forget(connection, name)
    choose_fits(connection, (), checksums)


def _look(path: Path, name: str, stamp: Stamp) -> Looked:
    if name.lower().endswith(SESSION_ENDINGS):
        return name, stamp, read_entry(path, name), None
    is_model = stamp[1] <= MOST_MODEL_BYTES and looks_like_model(path)
    return name, stamp, None, read_fits(path) if is_model else None


def _files(folder: Path) -> Iterator[tuple[str, Stamp]]:
    waiting = [""]
    while waiting:
        below = waiting.pop()
        try:
            with os.scandir(folder / below) as found:
                items = sorted(found, key=lambda item: item.name)
        except OSError:
            continue
        for item in items:
            name = f"{below}{item.name}"
            if item.name.startswith("."):
                continue
            if item.is_dir(follow_symlinks=False):
                waiting.append(f"{name}/")
            elif item.name.lower().endswith(_SUFFIXES) and item.is_file(follow_symlinks=False):
                with suppress(OSError):  # it has just gone
                    state = item.stat()
                    yield name, (state.st_mtime_ns, state.st_size)
