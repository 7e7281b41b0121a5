"""A table of text cells, whose rows know their place, so that every fault is named with it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np

from drivers.interfaces import FloatArray
from labrig.errors import BadInputError
from labrig.session.tables.decimals import from_plain
from labrig.session.tables.text.layout import Cells, TextLayout
from labrig.session.tables.text.meaning import ColumnMeaning, How

NUMBER = "a number"
_MOST_DIGITS = 9  # a session counts in 32 bits
_NOTHING = frozenset({"nan", "na", "n/a", "none", "null", "-", "--"})
_WITHOUT = "; leave lines out in which nothing was measured"
_EMPTY = "; leave the cell empty where nothing was measured"
_CLOCK = re.compile(r"(\d{4}-\d\d-\d\d[ T])?\d{1,2}:\d\d(:\d\d([.,]\d*)?)?")
Value = TypeVar("Value")


@dataclass(frozen=True, kw_only=True)
class TextTable:
    """The lines of a file that hold values, as text in our units and with decimal points."""

    path: Path
    kind: str
    encoding: str
    layout: TextLayout
    decimal_comma: bool
    meanings: tuple[ColumnMeaning, ...]
    values: dict[str, str]  # columns that are the same in all lines
    cells: list[Cells]
    lines: list[int]  # numbers in the file, from 1
    arc_radius_m: float | None = None  # that angles were multiplied by

    @cached_property
    def columns(self) -> dict[str, int]:
        """Where each of our columns is."""
        return {one.means: one.index for one in self.meanings if one.means}

    @property
    def as_ours(self) -> bool:
        """Whether the file is written as labrig writes it."""
        named = all(one.how is How.NAMED for one in self.meanings)
        plain = self.layout.plain and self.encoding == "UTF-8" and not self.decimal_comma
        return named and plain and not self.values

    def text(self, index: int, column: str) -> str:
        """Return a cell; empty where there is none."""
        at = self.columns.get(column)
        return self.values.get(column, "") if at is None else self.cells[index][at]

    def has(self, column: str) -> bool:
        """Whether the file has a column, or one value of it for all lines."""
        return column in self.columns or column in self.values

    def after(self, prefix: str) -> list[str]:
        """Return the columns whose names begin so."""
        return [name for name in self.columns if name.startswith(prefix)]

    def as_named(self, column: str) -> str:
        """Return the name of a column, with the file's own where that is another."""
        own = [one.name for one in self.meanings if one.means == column != one.name]
        return f"{column} ({own[0]})" if own else column

    def row(self, index: int) -> CsvRow:
        """Return a line."""
        return CsvRow(self, index)

    def rows(self) -> list[CsvRow]:
        """Return all lines."""
        return [CsvRow(self, index) for index in range(len(self.lines))]

    def numbers(
        self, column: str, read: Callable[[str], float], *, milli: bool, needed: bool
    ) -> FloatArray:
        """Return a column in SI units, NaN where it may be empty and is.

        `read` is how one cell is read, and says what is wrong with it: "12.5" with "e-3" behind it
        is the same number as 12.5 shifted by three places, so most need not be read one by one.
        """
        at = self.columns.get(column)
        if at is not None:
            with suppress(ValueError):  # below it is told with its line
                found = _numbers([row[at] for row in self.cells], read, "e-3" if milli else "")
                if not (needed and np.isnan(found).any()):
                    return found
        elif not needed and not self.has(column):
            return np.full(len(self.cells), math.nan)
        if needed:
            return np.array([row.get(column, read, NUMBER) for row in self.rows()])
        return np.array([row.optional(column, read, NUMBER, math.nan) for row in self.rows()])

    def blocks(self, columns: Sequence[str]) -> Iterator[tuple[int, int]]:
        """Yield first and end of lines that follow each other with the same text in columns."""
        at = [self.columns[name] for name in columns if name in self.columns]
        first, before = 0, None
        for index, row in enumerate(self.cells):
            key = [row[k] for k in at]
            if key != before:
                if before is not None:
                    yield first, index
                first, before = index, key
        if before is not None:
            yield first, len(self.cells)


class CsvRow:
    """One line of a table."""

    def __init__(self, table: TextTable, index: int) -> None:
        self._table = table
        self.index = index

    @property
    def file(self) -> Path:
        """The file's name."""
        return self._table.path

    @property
    def line(self) -> int:
        """The line's number, from 1."""
        return self._table.lines[self.index]

    def get(self, column: str, read: Callable[[str], Value], wanted: str) -> Value:
        """Return a value that must be there."""
        text = self._table.text(self.index, column)
        if not text:
            advice = _WITHOUT if wanted == NUMBER else ""
            raise self.fault(f"column {column} is empty; {wanted} is needed{advice}")
        return self._read(column, text, read, wanted, _WITHOUT)

    def optional(
        self, column: str, read: Callable[[str], Value], wanted: str, default: Value
    ) -> Value:
        """Return a value that may be missing or empty."""
        text = self._table.text(self.index, column)
        return self._read(column, text, read, wanted, _EMPTY) if text else default

    def has(self, column: str) -> bool:
        """Whether the file has a column."""
        return self._table.has(column)

    def in_file(self, column: str) -> bool:
        """Whether a column is in the file itself, not stated for all lines."""
        return column in self._table.columns

    def values_after(self, prefix: str) -> dict[str, float]:
        """Return the numbers in columns that begin with `prefix`, by the rest of their names."""
        cells = {name: self._table.text(self.index, name) for name in self._table.after(prefix)}
        return {
            name.removeprefix(prefix): self._read(name, text, from_plain, NUMBER, _EMPTY)
            for name, text in cells.items()
            if text
        }

    def fault(self, text: str) -> BadInputError:
        """Return an error at this line."""
        return BadInputError(f"{self.file}, line {self.line}: {text}.")

    def _read(
        self, column: str, text: str, read: Callable[[str], Value], wanted: str, without: str
    ) -> Value:
        try:
            return read(text)
        except ValueError:
            if column not in self._table.columns:
                raise BadInputError(f"--value {column}={text}: {text!r} is not {wanted}.") from None
            asked = self._table.as_named(column)
            advice = _advice(text, without) if wanted == NUMBER else ""
            raise self.fault(f"column {asked}: {text!r} is not {wanted}{advice}") from None


def _advice(text: str, without: str) -> str:
    """Return what to do about a text in place of a number; empty where it may be anything."""
    if text.lower() in _NOTHING:
        return without
    return "; give seconds since the beginning" if _CLOCK.fullmatch(text) else ""


def _numbers(texts: Sequence[str], read: Callable[[str], float], behind: str) -> FloatArray:
    """Return numbers, NaN for an empty text. Raises ValueError for what is no finite number.

    12.5 mm is the number "12.5e-3" in m, to the last bit; `read` takes what is written otherwise.
    """
    with suppress(ValueError):
        found = np.array([float(text + behind) if text else math.nan for text in texts])
        if np.count_nonzero(~np.isfinite(found)) == texts.count(""):
            return found
    return np.array([read(text) if text else math.nan for text in texts])


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
