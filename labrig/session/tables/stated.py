"""What a user states of the columns of other people's tables, as typed: force_mN=F."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

from labrig.errors import BadInputError
from labrig.session.tables.columns import CHANNEL
from labrig.session.tables.text.meaning import ColumnNames
from labrig.session.tables.text.names import KNOWN


def column_names(columns: Sequence[str] | None, values: Sequence[str] | None) -> ColumnNames:
    """Return what --columns and --value say. Raises BadInputError."""
    named = dict(_pair("--columns", text, "the name in the file") for text in columns or ())
    same = dict(_pair("--value", text, "the value in all lines") for text in values or ())
    for ours in named.keys() & same.keys():
        raise BadInputError(f"--value {ours}: --columns names a column for it already; give one.")
    return ColumnNames(columns=named, values=same)


def _pair(option: str, text: str, what: str) -> tuple[str, str]:
    ours, _, theirs = (part.strip() for part in text.partition("="))
    if not ours or not theirs:
        raise BadInputError(f"{option} {text!r}: write labrig's column, '=' and {what}.")
    if ours not in KNOWN and not ours.startswith(CHANNEL):
        close = difflib.get_close_matches(ours, KNOWN, n=1, cutoff=0.5)
        hint = f"did you mean {close[0]}" if close else "labrig import --help lists them"
        raise BadInputError(f"{option} {text!r}: {ours!r} is no column of labrig's; {hint}.")
    return ours, theirs
