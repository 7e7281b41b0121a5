"""What a person asks for, as files: paths, folders, and patterns that no shell has expanded."""

from __future__ import annotations

import glob
import os
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from labrig.batch.contract import TABLES, BatchInput, InputKind
from labrig.config.file_kinds import MODEL, SESSION, SHEET
from labrig.errors import BadInputError
from labrig.files import SESSION_ENDINGS
from labrig.library.fits import looks_like_model

_SUFFIXES = (*SESSION_ENDINGS, ".toml")
_BEGIN_BYTES = 1 << 16
_WORDS = {
    InputKind.SESSION: f"{SESSION} (.h5)",
    InputKind.TABLES: f"{SHEET} with forces.csv or curves.csv beside it",
    InputKind.MODEL: MODEL,
}


@dataclass(frozen=True)
class FoundInputs:
    """The inputs in the order of their names; how many other files the patterns matched."""

    inputs: list[BatchInput]
    left_out: int


def found_inputs(
    patterns: Sequence[str], takes: Collection[InputKind], seen_from: Path
) -> FoundInputs:
    """Return what the patterns name, each file once.

    A folder stands for all that fits in it and below. Of what a folder or a pattern yields, files
    of other kinds are left out. Raises BadInputError for a file that does not fit or is not there,
    and for a pattern that yields nothing.
    """
    found: dict[Path, InputKind] = {}
    others: set[Path] = set()
    for text in patterns:
        path = Path(text)
        if path.is_dir():
            new = _fitting(_below(path), takes, others)
        elif path.exists() or not glob.has_magic(text):
            new = {path: _only(path, takes)}
        else:
            every = (Path(one) for one in glob.iglob(text, recursive=True))
            new = _fitting((one for one in every if one.is_file()), takes, others)
        if not new:
            raise BadInputError(f"{text}: holds nothing to work on; {_wanted(takes)} is needed.")
        for one, kind in new.items():
            found.setdefault(_absolute(one), kind)
    inputs = [BatchInput(kind, path, _name(path, seen_from)) for path, kind in found.items()]
    return FoundInputs(sorted(inputs, key=lambda one: one.name), len(others))


def _wanted(takes: Collection[InputKind]) -> str:
    return " or ".join(_WORDS[kind] for kind in InputKind if kind in takes)


def _only(path: Path, takes: Collection[InputKind]) -> InputKind:
    if not path.exists():
        raise BadInputError(f"{path}: there is no such file.")
    kind = _kind(path, takes)
    if kind is None:
        raise BadInputError(f"{path}: cannot be used; {_wanted(takes)} is needed.")
    return kind


def _fitting(
    paths: Iterator[Path], takes: Collection[InputKind], others: set[Path]
) -> dict[Path, InputKind]:
    found = {}
    for path in paths:
        kind = _kind(path, takes)
        if kind is None:
            others.add(path)
        else:
            found[path] = kind
    return found


def _kind(path: Path, takes: Collection[InputKind]) -> InputKind | None:
    """Return what a file may be used as: by its name, and a model file by its beginning."""
    if path.suffix.lower() in SESSION_ENDINGS:
        kind: InputKind | None = InputKind.SESSION
    elif path.suffix != ".toml":
        kind = None
    elif InputKind.TABLES in takes and _has_tables(path):
        kind = InputKind.TABLES
    else:
        kind = InputKind.MODEL if looks_like_model(path) else None
    return kind if kind in takes else None


def _has_tables(path: Path) -> bool:
    """Whether a TOML file is of a sheet, and forces or curves lie beside it."""
    if not any(path.with_name(f"{name}.csv").is_file() for name in TABLES[:2]):
        return False
    try:
        with path.open("rb") as file:
            return b"free_length_mm" in file.read(_BEGIN_BYTES)
    except OSError:
        return False


def _below(folder: Path) -> Iterator[Path]:
    """Yield sessions, sheets and models below a folder; hidden folders and links are left out."""
    waiting = [folder]
    while waiting:
        try:
            with os.scandir(waiting.pop()) as items:
                inside = [item for item in items if not item.name.startswith(".")]
        except OSError:
            continue
        for item in inside:
            if item.is_dir(follow_symlinks=False):
                waiting.append(Path(item.path))
            elif item.name.lower().endswith(_SUFFIXES) and item.is_file(follow_symlinks=False):
                yield Path(item.path)


def _absolute(path: Path) -> Path:
    return Path(os.path.normpath(path.absolute()))


def _name(path: Path, seen_from: Path) -> str:
    """Return the path as seen from a folder, so that both may be moved together."""
    try:
        return Path(os.path.relpath(path, seen_from)).as_posix()
    except ValueError:  # another drive of Windows
        return path.as_posix()
