"""What a user states of the columns of other people's tables, as typed: force_mN=F."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from contextlib import suppress

from labrig.errors import BadInputError
from labrig.session.tables.columns import CHANNEL
from labrig.session.tables.csv_rows import TextTable
from labrig.session.tables.text.meaning import ColumnNames
from labrig.session.tables.text.names import KNOWN


def column_names(columns: Sequence[str] | None, values: Sequence[str] | None) -> ColumnNames:
    """Return what --columns and --value say. Raises BadInputError."""
    named = dict(_pair("--columns", text, "the name in the file") for text in columns or ())
    same = dict(_pair("--value", text, "the value in all lines") for text in values or ())
    for ours in named.keys() & same.keys():
        raise BadInputError(f"--value {ours}: --columns names a column for it already; give one.")
    return ColumnNames(columns=named, values=same)


def refuse_contradicted(names: ColumnNames, tables: Sequence[TextTable]) -> None:
    """Raise BadInputError for a stated value that no table needs, as each has others of its own."""
    for ours, text in names.values.items():
        asked = [table for table in tables if table.has(ours)]
        if not asked or any(ours not in table.columns for table in asked):
            continue
        for table in asked:
            cells = {table.text(index, ours) for index in range(len(table.lines))}
            other = sorted(cell for cell in cells if not _alike(cell, text))
            if other:
                raise BadInputError(
                    f"--value {ours}={text}: {table.path} has a column {table.as_named(ours)}, "
                    f"with {other[0]!r} in it; leave --value out, or remove the column."
                )


def _alike(one: str, other: str) -> bool:
    with suppress(ValueError):
        return float(one) == float(other)
    return one == other


def _pair(option: str, text: str, what: str) -> tuple[str, str]:
    ours, _, theirs = (part.strip() for part in text.partition("="))
    of_a_free_sheet = option == "--value" and "=" in text and ours == "position_mm"
    if not ours or not (theirs or of_a_free_sheet):
        raise BadInputError(f"{option} {text!r}: write labrig's column, '=' and {what}.")
    if ours not in KNOWN and not ours.startswith(CHANNEL):
        close = difflib.get_close_matches(ours, KNOWN, n=1, cutoff=0.5)
        hint = f"did you mean {close[0]}" if close else "labrig import --help lists them"
        raise BadInputError(f"{option} {text!r}: {ours!r} is no column of labrig's; {hint}.")
    return ours, theirs
