"""Which kind of file something is, by what is in it: so that a mix-up is told as one."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from labrig.errors import BadInputError

RIG, SHEET, PROTOCOL = "a rig.toml", "a sheet.toml", "a protocol.toml"
MODEL, CONTROLLER, ABOUT = "a model file", "a controller.toml", "an about.toml"
LOAD_CELL, OPTICS, SESSION = "a load_cell.toml", "an optics.json", "a session"
EMPTY, IMAGE, TEXT, PDF = "an empty file", "an image", "a text file", "a PDF"
FORCES, CURVES, SIGNALS = "a forces.csv", "a curves.csv", "a signals.csv"
ARCHIVE = "a ZIP archive or an office document"

_BEGINNINGS = {
    b"\x89HDF": SESSION,
    b"\x89PNG": IMAGE,
    b"\xff\xd8\xff": IMAGE,
    b"BM": IMAGE,
    b"II*\x00": IMAGE,
    b"MM\x00*": IMAGE,
    b"%PDF": PDF,
    b"PK\x03\x04": ARCHIVE,
}
# Keys at top level of which one is enough, by kind.
_KEYS = {
    MODEL: {"labrig_model"},
    CONTROLLER: {"labrig_controller"},
    PROTOCOL: {"places"},
    RIG: {"load_cell", "amplifier", "limits", "replay"},
    LOAD_CELL: {"sensitivity_V_per_N"},
    SHEET: {"arc", "free_length_mm"},
    ABOUT: {"title", "project", "licence", "people", "sample"},
}
# Signals may have a force, too.
_COLUMNS = {FORCES: {"force_mN", "voltage_V"}, CURVES: {"point"}, SIGNALS: {"drive_V"}}
# How somebody who has none comes to one.
_MADE_BY = {
    MODEL: " (`labrig fit SESSION -o model.toml` writes one)",
    CONTROLLER: " (`labrig control MODEL -o controller.toml` writes one)",
    LOAD_CELL: " (`labrig calibrate load-cell` writes one)",
    OPTICS: " (`labrig calibrate camera` writes one)",
    SESSION: " (`labrig run` makes one, `labrig import` one of tables)",
    **dict.fromkeys((RIG, SHEET, PROTOCOL), " (`labrig init` writes one)"),
}
_MOST_BYTES = 1 << 20  # more is told by its first bytes alone


def kind_of_bytes(begin: bytes) -> str:
    """Return the kind of a file that is no text, by its first bytes; empty: not known."""
    found = (kind for signature, kind in _BEGINNINGS.items() if begin.startswith(signature))
    return next(found, "")


def kinds_of_text(text: str) -> set[str]:
    """Return the kinds of file that a text may be; none where nothing tells."""
    if not text.strip():
        return {EMPTY}
    if text.lstrip().startswith("{"):
        return _kinds_of_json(text)
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError):
        columns = {name.strip() for name in text.partition("\n")[0].split(",")}
        return {kind for kind, own in _COLUMNS.items() if own <= columns}
    return kinds_of_toml(data)


def kinds_of_toml(data: Mapping[str, Any]) -> set[str]:
    """Return the kinds of file that the keys of a TOML file are of."""
    found = {kind for kind, keys in _KEYS.items() if keys & data.keys()}
    tables = [table for table in data.values() if isinstance(table, dict)]
    if any("free_length_mm" in table for table in tables):
        found.add(SHEET)
    return found


def _kinds_of_json(text: str) -> set[str]:
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return set()
    return {OPTICS} if {"px_per_mm", "clamp_px"} & data.keys() else {"a JSON file"}


def kind_of_file(path: Path) -> str:
    """Return the kind of a file; empty: not known, or of several."""
    with path.open("rb") as file:
        begin = file.read(_MOST_BYTES)
    binary = kind_of_bytes(begin)
    if binary or len(begin) == _MOST_BYTES:
        return binary
    try:
        kinds = kinds_of_text(begin.decode("utf-8-sig"))
    except UnicodeDecodeError:
        return ""
    return next(iter(kinds)) if len(kinds) == 1 else ""


def refuse_other_kind(text: str, name: str, wanted: str) -> None:
    """Raise BadInputError where a text is surely another kind of file than the one that is wanted.

    A file of the right kind with a key of another is left to those who know its keys.
    """
    kinds = kinds_of_text(text)
    if kinds and wanted not in kinds:
        raise other_kind(name, min(kinds), wanted)


def refuse_to_replace(path: Path, wanted: str) -> None:
    """Raise BadInputError for a folder, and for a file of another kind, which would be lost."""
    if path.is_dir():
        raise BadInputError(f"{path}: this is a folder; give the name of a file.")
    if not path.is_file():
        return
    kind = kind_of_file(path)
    if kind not in {wanted, EMPTY}:
        raise BadInputError(f"{path}: this is {kind or 'another file'}; give another name with -o.")


def other_kind(name: object, found: str, wanted: str) -> BadInputError:
    """Return the error of a mix-up."""
    how = _MADE_BY.get(wanted, "")
    if found == ARCHIVE and wanted in _COLUMNS:
        how = " (save each sheet of a spreadsheet as CSV)"
    return BadInputError(f"{name}: this is {found}; {wanted} is needed{how}.")
