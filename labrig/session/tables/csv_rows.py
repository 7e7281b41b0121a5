"""A CSV file as rows that know their place, so that every fault is named with it."""

from __future__ import annotations

import csv
import difflib
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from labrig.config import read_text
from labrig.config.file_kinds import CURVES, FORCES, SIGNALS, kinds_of_text, other_kind
from labrig.errors import BadInputError
from labrig.session.tables.decimals import from_plain

MOST_BYTES = 256 << 20  # days of samples
_MOST_DIGITS = 9  # a session counts in 32 bits
_MOST_OF_A_NAME = 40  # characters that are worth showing
_BEGIN = 1 << 16  # characters that tell which kind of file it is
_WANTED = {"point": CURVES, "force_mN": FORCES, "drive_V": SIGNALS}  # by the column they need
Value = TypeVar("Value")


class CsvRow:
    """One line of a file."""

    def __init__(self, file: Path, line: int, cells: Mapping[str, str]) -> None:
        self.file = file
        self.line = line
        self._cells = cells

    def get(self, column: str, read: Callable[[str], Value], wanted: str) -> Value:
        """Return a value that must be there."""
        text = self._cells.get(column, "")
        if not text:
            raise self.fault(f"column {column} is empty; {wanted} is needed")
        return self._read(column, text, read, wanted)

    def optional(
        self, column: str, read: Callable[[str], Value], wanted: str, default: Value
    ) -> Value:
        """Return a value that may be missing or empty."""
        text = self._cells.get(column, "")
        return self._read(column, text, read, wanted) if text else default

    def has(self, column: str) -> bool:
        """Whether the file has a column."""
        return column in self._cells

    def values_after(self, prefix: str) -> dict[str, float]:
        """Return the numbers in columns that begin with `prefix`, by the rest of their names."""
        return {
            name.removeprefix(prefix): self._read(name, text, from_plain, "a number")
            for name, text in self._cells.items()
            if name.startswith(prefix) and text
        }

    def fault(self, text: str) -> BadInputError:
        """Return an error at this line."""
        return BadInputError(f"{self.file}, line {self.line}: {text}.")

    def _read(self, column: str, text: str, read: Callable[[str], Value], wanted: str) -> Value:
        try:
            return read(text)
        except ValueError:
            raise self.fault(f"column {column}: {text!r} is not {wanted}") from None


def read_rows(
    path: Path, required: Sequence[str], optional: Sequence[str], prefix: str | None = None
) -> Iterator[CsvRow]:
    """Yield the rows of a file with these columns, in any order, and those named by the prefix.

    Accepts a byte order mark and any line ending; lines without a value are passed over.
    """
    return rows_of(read_text(path, MOST_BYTES), path, required, optional, prefix)


def rows_of(
    text: str,
    path: Path,
    required: Sequence[str],
    optional: Sequence[str],
    prefix: str | None = None,
) -> Iterator[CsvRow]:
    """Yield the rows of a file's text; `path` is what errors call it. See `read_rows`."""
    _refuse_other_kind(text, path, required)
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        header = [name.strip() for name in next(reader, [])]
        _check_header(path, header, required, optional, prefix)
        for cells in reader:
            if not any(cell.strip() for cell in cells):
                continue
            if len(cells) != len(header):
                raise BadInputError(
                    f"{path}, line {reader.line_num}: {len(cells)} values for {len(header)} "
                    "columns; a number must have a point, not a comma, for its decimals."
                )
            texts = {name: cell.strip() for name, cell in zip(header, cells, strict=True)}
            yield CsvRow(path, reader.line_num, texts)
    except csv.Error as error:
        raise BadInputError(f"{path}, line {reader.line_num}: not valid CSV: {error}.") from None


def _refuse_other_kind(text: str, path: Path, required: Sequence[str]) -> None:
    """Raise BadInputError for a file that is surely no such table."""
    wanted = next((kind for column, kind in _WANTED.items() if column in required), "a CSV table")
    kinds = kinds_of_text(text[:_BEGIN])
    alike = set(_WANTED.values()) if wanted == "a CSV table" else {wanted}
    if kinds and not kinds & alike:
        raise other_kind(path, min(kinds), wanted)


def _check_header(
    path: Path,
    header: Sequence[str],
    required: Sequence[str],
    optional: Sequence[str],
    prefix: str | None,
) -> None:
    known = [*required, *optional]
    if not header or header == [""]:
        raise BadInputError(f"{path}: is empty; its first line must name the columns.")
    if len(header) == 1 and (";" in header[0] or "\t" in header[0]):
        raise BadInputError(
            f"{path}: its columns must be separated by commas (and numbers have a point "
            "for their decimals)."
        )
    for name in header:
        if name not in known and not (prefix and name.startswith(prefix) and name != prefix):
            raise BadInputError(
                f"{path}: column {_short(name)!r} is not known; {_hint(name, known)}."
            )
        if header.count(name) > 1:
            raise BadInputError(f"{path}: column {name} is there twice.")
    for name in required:
        if name not in header:
            raise BadInputError(f"{path}: column {name} is missing; it is required.")


def _short(name: str) -> str:
    return name if len(name) <= _MOST_OF_A_NAME else f"{name[:_MOST_OF_A_NAME]}..."


def _hint(name: str, known: Sequence[str]) -> str:
    close = difflib.get_close_matches(name[:_MOST_OF_A_NAME], known, n=1, cutoff=0.5)
    return f"did you mean {close[0]}" if close else f"the columns are {', '.join(known)}"


def integer(text: str) -> int:
    """Return a whole number that is not negative. Raises ValueError."""
    if not text.isascii() or not text.isdigit() or len(text) > _MOST_DIGITS:
        raise ValueError(text)
    return int(text)


def truth(text: str) -> bool:
    """Return true or false. Raises ValueError."""
    values = {"true": True, "false": False, "1": True, "0": False}
    found = values.get(text.lower())
    if found is None:
        raise ValueError(text)
    return found


def one_of(*allowed: str) -> Callable[[str], str]:
    """Return a word among some. Raises ValueError."""

    def read(text: str) -> str:
        if text not in allowed:
            raise ValueError(text)
        return text

    return read
