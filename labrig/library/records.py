"""Entries and model files as rows of the catalogue, and back."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from typing import Any, cast

from labrig.library.database import NUMBER_COLUMNS, TEXT_COLUMNS
from labrig.library.entry import CatalogueEntry
from labrig.library.fits import Fits, Kind, ModelFits, Rank, shown_fits
from labrig.serialise import finite

_FITTED = ("B_Nm2", "E_Pa", "EIBM_Nm", "rmse_force_mN", "rmse_curve_mm")
_COLUMNS = (*TEXT_COLUMNS, *NUMBER_COLUMNS)
_TUPLES = frozenset(
    field.name for field in fields(CatalogueEntry) if str(field.type).startswith("tuple")
)
_BESIDE = ("fit", "fit_outdated")  # kept beside the entry, since model files change them
_PUT = (
    f"INSERT INTO sessions (name, damaged, {', '.join(_COLUMNS)})"  # noqa: S608 - names of ours
    f" VALUES (?, ?, {', '.join('?' * len(_COLUMNS))}) ON CONFLICT (name) DO UPDATE SET damaged ="
    f" excluded.damaged, {', '.join(f'{name} = excluded.{name}' for name in _COLUMNS)}"
)
_SET_FITTED = f"UPDATE sessions SET {', '.join(f'{name} = ?' for name in _FITTED)} WHERE id = ?"  # noqa: S608


def put_entry(connection: sqlite3.Connection, entry: CatalogueEntry) -> int:
    """Put a session in place of what is known of its file; returns its id."""
    connection.execute(_PUT, (entry.name, entry.error is not None, *_cells(entry)))
    (number,) = connection.execute(
        "SELECT id FROM sessions WHERE name = ?", (entry.name,)
    ).fetchone()
    _forget_parts(connection, number)
    plain = {key: value for key, value in vars(entry).items() if key not in _BESIDE}
    text = _text(plain)
    connection.execute("INSERT INTO entries VALUES (?, ?, NULL, 0)", (number, text))
    connection.execute("INSERT INTO texts VALUES (?, ?)", (number, _words(entry)))
    connection.executemany(
        "INSERT OR IGNORE INTO sheets VALUES (?, ?)", [(name, number) for name in entry.sheet]
    )
    connection.executemany(
        "INSERT OR IGNORE INTO data VALUES (?, ?)",
        [(one, number) for one in (entry.checksum, *entry.earlier_checksums) if one],
    )
    return int(number)


def put_model(connection: sqlite3.Connection, name: str, changed: int, one: ModelFits) -> None:
    """Put a model file in place of what is known of it."""
    text = _text(one.fits)
    connection.execute(
        "INSERT OR REPLACE INTO models VALUES (?, ?, ?, ?, ?)",
        (name, one.checksum, changed, one.kind, text),
    )


def forget(connection: sqlite3.Connection, name: str) -> set[str]:
    """Remove what is known of a file; returns the checksums whose fits may have changed."""
    connection.execute("DELETE FROM files WHERE name = ?", (name,))
    found = connection.execute("SELECT id FROM sessions WHERE name = ?", (name,)).fetchone()
    if found is not None:
        _forget_parts(connection, found[0])
        connection.execute("DELETE FROM sessions WHERE id = ?", found)
    model = connection.execute("SELECT checksum FROM models WHERE name = ?", (name,)).fetchone()
    connection.execute("DELETE FROM models WHERE name = ?", (name,))
    return set() if model is None else {str(model[0])}


def _forget_parts(connection: sqlite3.Connection, number: int) -> None:
    for table in ("entries", "texts", "sheets", "data"):
        connection.execute(f"DELETE FROM {table} WHERE id = ?", (number,))  # noqa: S608


def choose_fits(
    connection: sqlite3.Connection, ids: Iterable[int], checksums: Iterable[str]
) -> None:
    """Choose the fit of these new sessions, and of those whose data have these checksums."""
    chosen = {number for number in ids if _has_model(connection, number)}
    for one in checksums:
        asked = connection.execute("SELECT id FROM data WHERE checksum = ?", (one,))
        chosen |= {number for (number,) in asked}
    for number in chosen:
        models = connection.execute(
            "SELECT m.name, m.changed, m.checksum, m.kind, m.fits FROM data d"
            " JOIN models m ON m.checksum = d.checksum WHERE d.id = ?",
            (number,),
        ).fetchall()
        entry = _entry_of(connection, number)
        files = (
            (name, changed, ModelFits(checksum, cast("Kind", kind), json.loads(text)))
            for name, changed, checksum, kind, text in models
        )
        fits = shown_fits(entry.name, files)
        fitted = with_fit(replace(entry, fit=None, fit_outdated=False), fits)
        text = None if fitted.fit is None else _text(fitted.fit)
        connection.execute(
            "UPDATE entries SET fit = ?, outdated = ? WHERE id = ?",
            (text, fitted.fit_outdated, number),
        )
        values = [fitted.fitted(name) for name in _FITTED]
        connection.execute(_SET_FITTED, (*values, number))


def _text(plain: Any) -> str:
    """Return JSON; a number that JSON does not have, which is rare, is null."""
    try:
        return json.dumps(plain, ensure_ascii=False, allow_nan=False)
    except ValueError:
        return json.dumps(finite(plain), ensure_ascii=False, allow_nan=False)


def _has_model(connection: sqlite3.Connection, number: int) -> bool:
    asked = connection.execute(
        "SELECT 1 FROM data d JOIN models m ON m.checksum = d.checksum WHERE d.id = ? LIMIT 1",
        (number,),
    )
    return asked.fetchone() is not None


def _entry_of(connection: sqlite3.Connection, number: int) -> CatalogueEntry:
    row = connection.execute(
        "SELECT entry, fit, outdated FROM entries WHERE id = ?", (number,)
    ).fetchone()
    return entry_of_row(row)


def entry_of_row(row: tuple[str, str | None, int]) -> CatalogueEntry:
    """Return the entry of a row of `entries`."""
    text, fit, outdated = row
    plain = json.loads(text)
    for name in _TUPLES:
        plain[name] = tuple(plain[name])
    return CatalogueEntry(
        **plain, fit=None if fit is None else json.loads(fit), fit_outdated=bool(outdated)
    )


def with_fit(entry: CatalogueEntry, fits: Mapping[str, tuple[Rank, Fits]]) -> CatalogueEntry:
    """Add the fit to the data as they are, else the one to those before the last marks."""
    if entry.checksum in fits:
        return replace(entry, fit=fits[entry.checksum][1])
    earlier = [fits[checksum] for checksum in entry.earlier_checksums if checksum in fits]
    if not earlier:
        return entry
    return replace(entry, fit=max(earlier, key=lambda fit: fit[0])[1], fit_outdated=True)


def _cells(entry: CatalogueEntry) -> list[Any]:
    """Return what is sorted by; what is not known is NULL."""
    return [_cell(None if name in _FITTED else getattr(entry, name)) for name in _COLUMNS]


def _cell(value: Any) -> Any:
    if isinstance(value, tuple):
        value = ", ".join(value)
    return None if value == "" else value


def _words(entry: CatalogueEntry) -> str:
    parts = (entry.name, entry.protocol, *entry.sheet, entry.reason, entry.error or "", entry.words)
    return " ".join(parts).lower()
