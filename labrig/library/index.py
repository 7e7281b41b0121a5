"""The entries of a folder, looked up again only where a file has changed."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from labrig.errors import BadInputError
from labrig.library.entry import CatalogueEntry, read_entry
from labrig.library.fits import Fits, ModelFits, Rank, looks_like_model, read_fits, shown_fits
from labrig.serialise import from_json, to_json

VERSION = 3  # of what is kept
KEPT = ".labrig/library.json"
MOST_FILES = 100_000
MOST_MODEL_BYTES = 1 << 20
_SAVE_EVERY_S = 5.0
_SUFFIXES = (".h5", ".toml")

Stamp = tuple[int, int]  # time of the last change in ns, size
Advance = Callable[[float, str], None]


@dataclass(frozen=True)
class _Known:
    """What a file of this stamp holds: a session's entry, or a model's fits, or neither."""

    stamp: Stamp
    entry: CatalogueEntry | None = None
    fits: ModelFits | None = None


@dataclass(frozen=True)
class _Kept:
    """The content of the file in which a library keeps what it knows."""

    version: int
    files: dict[str, _Known]


class Library:
    """One folder and all below it. May be asked from several threads."""

    def __init__(self, folder: Path) -> None:
        """Look into the folder; raise BadInputError when there is none."""
        if not folder.is_dir():
            if folder.exists():
                raise BadInputError(f"{folder}: this is a file, a folder is needed.")
            raise BadInputError(f"{folder}: there is no such folder.")
        self.folder = folder
        self._lock = threading.Lock()
        self._known = _load(folder / KEPT)

    def refresh(self, budget_s: float | None = None, advance: Advance | None = None) -> int:
        """Look at what has changed; the number of files that are left when the time is over."""
        with self._lock:
            return self._refresh(budget_s, advance)

    def entries(self) -> list[CatalogueEntry]:
        """All sessions as they were at the last `refresh`, with the fit that `fits` chooses."""
        with self._lock:
            known = dict(self._known)
        fits = shown_fits(
            (name, one.stamp[0], one.fits) for name, one in known.items() if one.fits is not None
        )
        return [with_fit(one.entry, fits) for one in known.values() if one.entry is not None]

    def _refresh(self, budget_s: float | None, advance: Advance | None) -> int:
        end_s = None if budget_s is None else time.monotonic() + budget_s
        there = dict(_files(self.folder))
        changed = [
            name
            for name, stamp in there.items()
            if name not in self._known or self._known[name].stamp != stamp
        ]
        gone = self._known.keys() - there.keys()
        for name in gone:
            del self._known[name]
        saved_s = time.monotonic()
        for count, name in enumerate(changed):
            # One at least, or a slow disk would keep whoever asks again and again waiting for ever.
            if count and end_s is not None and time.monotonic() > end_s:
                self._save()
                return len(changed) - count
            self._known[name] = _look(self.folder / name, name, there[name])
            if advance is not None:
                advance((count + 1) / len(changed), name)
            if time.monotonic() - saved_s > _SAVE_EVERY_S:
                self._save()
                saved_s = time.monotonic()
        if changed or gone:
            self._save()
        return 0

    def _save(self) -> None:
        """Store the entries, unless the folder is read-only: then they are read again next time."""
        path = self.folder / KEPT
        beside = path.with_name(f"{path.name}.{os.getpid()}.new")
        with suppress(OSError):
            path.parent.mkdir(exist_ok=True)
            beside.write_text(to_json(_Kept(VERSION, self._known)), encoding="utf-8")
            beside.replace(path)


def _look(path: Path, name: str, stamp: Stamp) -> _Known:
    if name.endswith(".h5"):
        return _Known(stamp, entry=read_entry(path, name))
    is_model = stamp[1] <= MOST_MODEL_BYTES and looks_like_model(path)
    return _Known(stamp, fits=read_fits(path) if is_model else None)


def _files(folder: Path) -> Iterator[tuple[str, Stamp]]:
    """Sessions and models, by name; hidden folders and links to folders are left out."""
    waiting, count = [""], 0
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
            elif item.name.endswith(_SUFFIXES) and item.is_file(follow_symlinks=False):
                with suppress(OSError):  # it has just gone
                    state = item.stat()
                    yield name, (state.st_mtime_ns, state.st_size)
                    count += 1
                    if count >= MOST_FILES:
                        return


def _load(path: Path) -> dict[str, _Known]:
    """Return what was stored; nothing where it is damaged or of another version."""
    try:
        kept = from_json(_Kept, path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return kept.files if kept.version == VERSION else {}


def with_fit(entry: CatalogueEntry, fits: Mapping[str, tuple[Rank, Fits]]) -> CatalogueEntry:
    """Add the fit to the data as they are, else the one to those before the last marks."""
    if entry.checksum in fits:
        return replace(entry, fit=fits[entry.checksum][1])
    earlier = [fits[checksum] for checksum in entry.earlier_checksums if checksum in fits]
    if not earlier:
        return entry
    return replace(entry, fit=max(earlier, key=lambda fit: fit[0])[1], fit_outdated=True)
