"""What a user states of the columns of other people's tables, as typed: force_mN=F."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from contextlib import suppress

from labrig.errors import BadInputError
from labrig.files import typed
from labrig.session.tables.columns import CHANNEL
from labrig.session.tables.csv_rows import TextTable
from labrig.session.tables.text.meaning import ColumnNames, as_typed, indices_of
from labrig.session.tables.text.names import KNOWN


def column_names(
    columns: Sequence[str] | None,
    values: Sequence[str] | None,
    ignored: Sequence[str] | None = None,
) -> ColumnNames:
    """Return what --columns, --value and --ignore say. Raises BadInputError."""
    named: dict[str, list[str]] = {}
    for text in columns or ():
        ours, theirs = _pair("--columns", text, "the name in the file")
        if theirs not in named.setdefault(ours, []):
            named[ours].append(theirs)
    same: dict[str, str] = {}
    for text in values or ():
        ours, value = _pair("--value", text, "the value in all lines")
        if same.setdefault(ours, value) != value:
            raise BadInputError(f"--value {ours}: it has two values; give one.")
    for ours in named.keys() & same.keys():
        raise BadInputError(f"--value {ours}: --columns names a column for it already; give one.")
    if any(not one.strip() for one in ignored or ()):
        raise BadInputError("--ignore '': write the name that the column has in the file.")
    return ColumnNames(columns=named, values=same, ignored=tuple(ignored or ()))


def refuse_unused(names: ColumnNames, tables: Sequence[TextTable]) -> None:
    """Raise BadInputError for a column that is stated and that no table has, or uses."""
    stated = [(as_typed(ours, [one]), one) for ours, each in names.columns.items() for one in each]
    ignored = [(f"--ignore {one}", one) for one in names.ignored]
    for option, theirs in (*stated, *ignored):
        with_it = [t for t in tables if indices_of(t.layout.names, [theirs])]
        if not with_it:
            there = ", ".join(dict.fromkeys(n for t in tables for n in t.layout.names if n))
            raise BadInputError(
                f"{option}: {theirs!r} is no column of {' or '.join(str(t.path) for t in tables)}, "
                f"which has {there}."
            )
    for ours, each in names.columns.items():
        for theirs in each:
            if not any(_is_taken(table, ours, theirs) for table in tables):
                raise BadInputError(
                    f"{as_typed(ours, [theirs])}: no table needs it; {_instead(ours, tables)}."
                )


def _is_taken(table: TextTable, ours: str, theirs: str) -> bool:
    at = table.columns.get(ours)
    return at is not None and at in indices_of(table.layout.names, [theirs])


def _instead(ours: str, tables: Sequence[TextTable]) -> str:
    """Return why a column of a table that a user names for ours is not taken."""
    others = [table for table in tables if ours in table.columns]
    if not others:
        return f"{ours} is no column of {' or '.join(one.kind for one in tables)}"
    taken = others[0].layout.names[others[0].columns[ours]]
    return f"{others[0].path} has {taken!r} for {ours}, which --ignore {typed(taken)} leaves out"


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
