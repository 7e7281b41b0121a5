"""What the pages about sessions share: names, and a session's entry as pages see it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from fastapi import Query

from labrig.library import CatalogueEntry, read_entry
from labrig.panel.core.panel import Panel

REFRESH_S = 1.0  # for files that have changed; the next request continues
Session = Annotated[str, Query(max_length=400)]


def entry_of(panel: Panel, path: Path, name: str) -> CatalogueEntry:
    """Return a session as the library knows it, with its fit; read now where it does not."""
    return panel.library.entry(name) or read_entry(path, name)


def shown(entry: CatalogueEntry) -> dict[str, Any]:
    """Return what pages see of a session."""
    plain = entry.as_dict()
    del plain["checksum"], plain["earlier_checksums"]
    return plain
