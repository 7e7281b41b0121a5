"""A text file as a table of cells under our names, whoever wrote it and however.

A table as labrig writes it (commas, decimal points, our names in the first line) is taken as it is.
In another one the letters, the line of names, separators, decimals, units and names are found out,
and its cells are turned into ours: the rest of the program reads one kind of table.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal, InvalidOperation
from pathlib import Path

from labrig.config import read_bytes
from labrig.config.file_kinds import (
    CURVES,
    FORCES,
    SIGNALS,
    kind_of_bytes,
    kinds_of_text,
    other_kind,
)
from labrig.errors import BadInputError
from labrig.session.tables.csv_rows import TextTable
from labrig.session.tables.decimals import MINUS, plain
from labrig.session.tables.text.decoding import LATIN, decoded
from labrig.session.tables.text.guesses import first_cells
from labrig.session.tables.text.layout import (
    COMMA,
    MOST_COLUMNS,
    Cells,
    TextLayout,
    find_layout,
    has_comma,
    has_point,
)
from labrig.session.tables.text.meaning import (
    AS_NAMED,
    ColumnMeaning,
    ColumnNames,
    ExpectedColumns,
    How,
    check,
    meanings,
)
from labrig.session.tables.text.spaces import tabs_for_spaces, without_marks

MOST_BYTES = 256 << 20  # days of samples
_DIGITS = 9  # after the point, of what an angle is turned into
_BEGIN = 1 << 16  # characters that tell which kind of file it is
_KINDS = {"forces": FORCES, "curves": CURVES, "signals": SIGNALS}
_A_TABLE = "a CSV table"
_WORDS = frozenset({"configuration", "kind", "valid", "why", "approach", "extra"})
# Many programs write all numbers alike: 3.000000 is reading 3.
_WHOLE = frozenset({"reading", "point", "mounting", "run", "mean_of"})


def read_table(path: Path, expected: ExpectedColumns, given: ColumnNames = AS_NAMED) -> TextTable:
    """Read a file. Raises BadInputError, which names file, line and column."""
    raw = read_bytes(path, _wanted(expected), MOST_BYTES)
    kind = kind_of_bytes(raw[:8])
    if kind:
        raise other_kind(path, kind, _wanted(expected))
    try:
        text, encoding = decoded(raw)
    except UnicodeDecodeError as error:
        raise BadInputError(
            f"{path}: not a text file (byte {error.start} cannot be read); save it as UTF-8."
        ) from None
    return table_of(text, path, expected, given, encoding=encoding)


def table_of(
    text: str,
    path: Path,
    expected: ExpectedColumns,
    given: ColumnNames = AS_NAMED,
    *,
    encoding: str = "UTF-8",
) -> TextTable:
    """Return the table in a text; `path` is what errors call it. See `read_table`."""
    _refuse_other_kind(text, path, expected)
    text, spaces = tabs_for_spaces(without_marks(text))
    layout = find_layout(text, lambda names: _recognised(names, expected, given))
    layout = replace(layout, spaces=spaces)
    file = str(path)
    if len(layout.names) > MOST_COLUMNS:
        raise BadInputError(
            f"{path}: its first line has {len(layout.names)} columns; a table has at most "
            f"{MOST_COLUMNS}."
        )
    values = {name: text for name, text in given.values.items() if name in expected.known}
    own = replace(given, values=values)
    found = meanings(file, layout, expected, own)
    if given.only_sheet and not any(one.means == "configuration" for one in found):
        values.setdefault("configuration", given.only_sheet)
    by_hand = bool(given.columns) or any(one.how in (How.WRITTEN, How.GUESSED) for one in found)
    plain = layout.plain and encoding == "UTF-8" and not by_hand
    letters = "; where letters of the file are wrong, save it as UTF-8" if encoding == LATIN else ""
    found = check(
        file, found, expected, own, plain=plain, cells=first_cells(text, layout), letters=letters
    )
    cells, lines = _body(text, path, layout, plain)
    table = TextTable(
        path=path,
        kind=expected.kind,
        encoding=encoding,
        layout=layout,
        decimal_comma=layout.delimiter != COMMA and _decimal_comma(path, found, cells, lines),
        meanings=tuple(found),
        values=values,
        cells=cells,
        lines=lines,
        arc_radius_m=given.arc_radius_m,
    )
    return _in_our_units(table)


def _wanted(expected: ExpectedColumns) -> str:
    return _KINDS.get(expected.kind, _A_TABLE)


def _refuse_other_kind(text: str, path: Path, expected: ExpectedColumns) -> None:
    """Raise BadInputError for a file that is surely no such table."""
    wanted = _wanted(expected)
    kinds = kinds_of_text(text[:_BEGIN])
    alike = set(_KINDS.values()) if wanted == _A_TABLE else {wanted}
    if kinds and not kinds & alike:
        raise other_kind(path, min(kinds), wanted)


def _recognised(names: Sequence[str], expected: ExpectedColumns, given: ColumnNames) -> int:
    """Return how many names are those of columns, for sure or by what the user states."""
    layout = TextLayout(names=tuple(names))
    try:
        found = meanings("", layout, expected, given)
    except BadInputError:
        return 1
    return sum(one.how is not How.UNUSED for one in found)


def _body(text: str, path: Path, layout: TextLayout, plain: bool) -> tuple[list[Cells], list[int]]:
    """Return the lines below the names, each with a cell for each name, and their numbers."""
    start = 0
    for _ in range(layout.first):
        start = text.find("\n", start) + 1
        if not start:
            return [], []
    below = io.StringIO(text[start:], newline="")
    reader = csv.reader(below, delimiter=layout.delimiter, strict=True)
    width, spaces = len(layout.names), " " in text
    cells: list[Cells] = []
    lines: list[int] = []
    try:
        for row in reader:
            if spaces:
                row = [cell.strip() for cell in row]
            if not any(row):
                continue
            if len(row) != width:
                row = _of_width(row, width, plain)
            if len(row) != width:
                raise BadInputError(
                    f"{path}, line {layout.first + reader.line_num}: {len(row)} values for {width} "
                    f"columns{_comma_hint(layout) if len(row) > width else ''}."
                )
            cells.append(row)
            lines.append(layout.first + reader.line_num)
    except csv.Error as error:
        raise BadInputError(
            f"{path}, line {layout.first + reader.line_num}: not valid CSV: {error}."
        ) from None
    return cells, lines


def _comma_hint(layout: TextLayout) -> str:
    if layout.delimiter == COMMA:
        return "; a number must have a point, not a comma, for its decimals"
    return ""


def _of_width(row: Cells, width: int, plain: bool) -> Cells:
    """Return a line without separators too many at its end.

    One of another program gets the empty cells that are missing there.
    """
    while len(row) > width and not row[-1]:
        row = row[:-1]
    if plain:
        return row
    return [*row, *[""] * (width - len(row))] if 1 < len(row) < width else row


def _decimal_comma(
    path: Path, found: Sequence[ColumnMeaning], cells: Sequence[Cells], lines: Sequence[int]
) -> bool:
    """Return whether decimals have a comma. Raises BadInputError where some have and some not."""
    at = [one.index for one in found if one.means and one.means not in _WORDS]
    seen: dict[bool, tuple[str, int]] = {}
    for row, line in zip(cells, lines, strict=True):
        for k in at:
            for comma, is_one in ((True, has_comma), (False, has_point)):
                if comma not in seen and is_one(row[k]):
                    seen[comma] = row[k], line
        if len(seen) > 1:
            break
    if len(seen) > 1:
        (with_comma, one), (with_point, other) = seen[True], seen[False]
        raise BadInputError(
            f"{path}, line {max(one, other)}: {with_comma!r} has a decimal comma and "
            f"{with_point!r} (line {min(one, other)}) a point; use one of them."
            if one > other
            else f"{path}, line {other}: {with_point!r} has a decimal point and "
            f"{with_comma!r} (line {one}) a comma; use one of them."
        )
    return True in seen


def _in_our_units(table: TextTable) -> TextTable:
    """Return a table whose cells have decimal points and our units, and whole numbers no point."""
    if table.as_ours:
        return table
    cells = [list(row) for row in table.cells]
    for one in table.meanings:
        if not one.means or one.means in _WORDS:
            continue
        for row in cells:
            text = row[one.index]
            if table.decimal_comma and has_comma(text):
                text = text.replace(",", ".")
            if one.means in _WHOLE:
                whole, _, rest = text.partition(".")
                text = text if rest.strip("0") else whole
            row[one.index] = _shifted(text, one)
    return replace(table, cells=cells)


def _shifted(text: str, column: ColumnMeaning) -> str:
    if not text or not (column.exponent or column.factor):
        return text
    try:
        number = Decimal(text.replace(MINUS, "-"))
        if column.factor is None:
            return str(number.scaleb(column.exponent))
        return plain(round(float(number * column.factor), _DIGITS))
    except InvalidOperation:
        return text  # whoever reads the number says what is wrong with it
