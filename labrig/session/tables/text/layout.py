"""Where a table begins in its file, and what separates its columns and its decimals."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

from labrig.session.tables.text.names import unit_of

COMMA, SEMICOLON, TAB = ",", ";", "\t"
IN_WORDS = {COMMA: "commas", SEMICOLON: "semicolons", TAB: "tabs"}
_MOST_HEADER = 400  # lines within which a table begins
MOST_COLUMNS = 500
_MOST_LOOKED_AT = 50  # lines of numbers that tell where it begins
_EXPONENT = r"(?:[eE][-+]?\d+)?"
_WITH_POINT = re.compile(rf"[-+\u2212]?(?:\d+\.?\d*|\.\d+){_EXPONENT}")
_WITH_COMMA = re.compile(rf"[-+\u2212]?(?:\d*,\d+){_EXPONENT}")
_NO_UNIT = ("", "-")

Cells = list[str]


@dataclass(frozen=True, kw_only=True)
class TextLayout:
    """How a table is written down."""

    delimiter: str = COMMA
    header: int = 0  # index of the line that names the columns; -1: none does
    first: int = 1  # index of the first line that may hold values
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()  # of a line of their own below the names
    spaces: bool = False  # whether the tabs are spaces in the file

    @property
    def plain(self) -> bool:
        """Whether it is written as labrig writes its own tables."""
        return self.delimiter == COMMA and self.header == 0 and not self.units


def is_number(text: str) -> bool:
    """Whether a cell is a number, with a point or a comma for its decimals."""
    return bool(_WITH_POINT.fullmatch(text) or _WITH_COMMA.fullmatch(text))


def has_comma(text: str) -> bool:
    """Whether a cell is a number with a decimal comma."""
    return "," in text and bool(_WITH_COMMA.fullmatch(text))


def has_point(text: str) -> bool:
    """Whether a cell is a number with a decimal point."""
    return "." in text and bool(_WITH_POINT.fullmatch(text))


def find_layout(text: str, recognised: Callable[[Sequence[str]], int]) -> TextLayout:
    """Return how the table in a text is written.

    `recognised` says how many of some names are those of columns. Where the first line names
    columns with commas between, that is the table; else the line is looked for.
    """
    lines = text.split("\n", _MOST_HEADER)[:_MOST_HEADER]
    first = split(lines[0], COMMA)
    if len(first) > MOST_COLUMNS or recognised(first) == len(first):
        below = split(lines[1], COMMA) if lines[1:] else []
        if _are_units(below, len(first)):
            return TextLayout(first=2, names=tuple(first), units=tuple(below))
        return TextLayout(names=tuple(first))
    found = [
        candidate
        for delimiter in IN_WORDS
        for candidate in _candidates([split(line, delimiter) for line in lines], delimiter)
    ]
    if not found:
        return TextLayout(names=tuple(first))
    return max(found, key=lambda one: (recognised(one[1].names), one[0]))[1]


def split(line: str, delimiter: str) -> Cells:
    """Return the cells of one line."""
    cells = line.split(delimiter)
    if '"' in line:
        with suppress(csv.Error):  # whoever reads the table says what is wrong with it
            cells = next(csv.reader([line], delimiter=delimiter), [])
    return [cell.strip() for cell in cells]


def _candidates(rows: list[Cells], delimiter: str) -> Iterator[tuple[int, TextLayout]]:
    """Yield each line that may name the columns of what follows, with how much does follow."""
    for at, cells in enumerate(rows):
        names = _without_empty_end(cells)
        if not 2 <= len(names) <= MOST_COLUMNS or (
            delimiter == COMMA and _holds(cells, SEMICOLON + TAB)
        ):
            continue
        if any(map(is_number, names)):
            width = len(cells)
            if at == 0 or not _holds_values(rows[at - 1], width):
                count = _values_below(rows, at, width)
                numbered = tuple(str(k + 1) for k in range(width))
                yield (
                    count * width - 1,  # a line of names above is better than none
                    TextLayout(delimiter=delimiter, header=-1, first=at, names=numbered),
                )
            continue
        below = at + 1
        units: tuple[str, ...] = ()
        if below < len(rows) and _are_units(rows[below], len(cells)):
            units, below = tuple(rows[below]), below + 1
        named = TextLayout(
            delimiter=delimiter, header=at, first=below, names=tuple(names), units=units
        )
        yield _values_below(rows, below, len(cells)) * len(names), named


def _holds(cells: Cells, signs: str) -> bool:
    return any(sign in cell for cell in cells for sign in signs)


def _values_below(rows: list[Cells], first: int, width: int) -> int:
    count = 0
    for cells in rows[first : first + _MOST_LOOKED_AT]:
        if not any(cells):
            continue
        if not _holds_values(cells, width):
            break
        count += 1
    return count


def _holds_values(cells: Cells, width: int) -> bool:
    own = _without_empty_end(cells)
    return 1 < len(own) <= width and any(map(is_number, own))


def _are_units(cells: Cells, width: int) -> bool:
    own = [cell.strip("[]()") for cell in cells]
    return len(own) == width and any(own) and all(cell in _NO_UNIT or unit_of(cell) for cell in own)


def _without_empty_end(cells: Cells) -> Cells:
    end = len(cells)
    while end and not cells[end - 1]:
        end -= 1
    return cells[:end]
