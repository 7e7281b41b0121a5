"""Checks of a page, and of what it shows.

Those of a page run when another distribution's page is loaded, those of what it shows for each
request.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

from drivers.kinds import call_fault

_MODES = {"rig", "sessions", "replay", "photographs"}


def faults(page: object) -> list[str]:
    """Return what is wrong with a page, a sentence each; none when it keeps the contract."""
    return list(_faults(page))


def _faults(page: object) -> Iterator[str]:
    title = getattr(page, "title", None)
    if not isinstance(title, str) or not title.strip():
        yield "its title must be a text"
    order = getattr(page, "order", None)
    if isinstance(order, bool) or not isinstance(order, int | float) or not math.isfinite(order):
        yield "its order must be a finite number"
    for name in ("modes", "opens"):
        modes = getattr(page, name, None)
        if not isinstance(modes, frozenset) or not modes <= _MODES:
            yield f"{name} must be a frozenset of {', '.join(sorted(_MODES))}"
    yield from _source_faults(page)


def _source_faults(page: object) -> Iterator[str]:
    from fastapi import APIRouter

    script, data = getattr(page, "script", None), getattr(page, "data", None)
    if script is None and data is None:
        yield "it has neither a script nor data to show"
    if script is not None and not (
        isinstance(script, Path) and script.suffix == ".js" and script.is_file()
    ):
        yield f"its script {script} must be the path of a .js file"
    if data is not None and (fault := call_fault("data", data, ("panel",))):
        yield fault
    if not isinstance(getattr(page, "router", None), APIRouter | None):
        yield "router must be a fastapi.APIRouter"


def content_faults(data: object) -> list[str]:
    """Return what is wrong with what the `data` of a page without a script returned."""
    if not isinstance(data, Mapping):
        return [f"data returned {_kind(data)}, not a dict with 'sentences' and 'tables'"]
    return list(_content(data))


def json_faults(value: object, where: str = "data") -> Iterator[str]:
    """Yield what of a value cannot be sent as JSON, with its place in it."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            if not isinstance(key, str):
                yield f"{where} has the key {key!r}, which is {_kind(key)}, not a text"
            yield from json_faults(inner, f"{where}.{key}")
    elif isinstance(value, list | tuple):
        for at, inner in enumerate(value):
            yield from json_faults(inner, f"{where}[{at}]")
    else:
        yield from _scalar_faults(value, where)


def _content(data: Mapping[object, object]) -> Iterator[str]:
    yield from _other_keys(data, "data", ("sentences", "tables"))
    yield from _texts(data.get("sentences", ()), "sentences")
    tables = data.get("tables", ())
    if not isinstance(tables, list | tuple):
        yield f"tables is {_kind(tables)}, not a list"
        return
    for at, table in enumerate(tables):
        yield from _table(table, f"tables[{at}]")


def _table(table: object, where: str) -> Iterator[str]:
    if not isinstance(table, Mapping):
        yield f"{where} is {_kind(table)}, not a dict"
        return
    yield from _other_keys(table, where, ("title", "columns", "rows"))
    title = table.get("title", "")
    if not isinstance(title, str):
        yield f"{where}.title is {_kind(title)}, not a text"
    columns, rows = table.get("columns", ()), table.get("rows", ())
    yield from _texts(columns, f"{where}.columns")
    if not isinstance(rows, list | tuple):
        yield f"{where}.rows is {_kind(rows)}, not a list"
        return
    count = len(columns) if isinstance(columns, list | tuple) else 0
    for at, row in enumerate(rows):
        yield from _row(row, f"{where}.rows[{at}]", count)


def _row(row: object, where: str, columns: int) -> Iterator[str]:
    if not isinstance(row, list | tuple):
        yield f"{where} is {_kind(row)}, not a list"
    elif columns and len(row) != columns:
        cells = f"{len(row)} cell{'' if len(row) == 1 else 's'}"
        yield f"{where} has {cells}, not {columns}, the number of its columns"
    else:
        for at, cell in enumerate(row):
            yield from _scalar_faults(cell, f"{where}[{at}]")


def _texts(texts: object, where: str) -> Iterator[str]:
    if not isinstance(texts, list | tuple):
        yield f"{where} is {_kind(texts)}, not a list"
        return
    for at, text in enumerate(texts):
        if not isinstance(text, str):
            yield f"{where}[{at}] is {_kind(text)}, not a text"


def _scalar_faults(value: object, where: str) -> Iterator[str]:
    if isinstance(value, float) and not math.isfinite(value):
        yield f"{where} is {value}: JSON has no such number; use None for what is not known"
    elif not isinstance(value, str | int | float | None):
        yield f"{where} is {_kind(value)}, not a text, a number, True, False or None"


def _other_keys(
    found: Mapping[object, object], where: str, known: tuple[str, ...]
) -> Iterator[str]:
    for key in found:
        if key not in known:
            yield f"{where} has {key!r}, which is none of {', '.join(known)}"


def _kind(value: object) -> str:
    name = type(value).__name__
    if value is None:
        return name
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"
