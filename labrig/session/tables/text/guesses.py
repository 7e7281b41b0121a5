"""Which columns of a file may be one that is missing: offered in a question, never taken."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from typing import Final

from labrig.session.tables.text.layout import TextLayout, is_number
from labrig.session.tables.text.names import KNOWN, SplitName, fits, may_mean, words_for

_ALIKE: Final = 0.6  # of two words, from 0 to 1
_LONG: Final = 4  # letters of a name that may be part of another
_WORDS: Final = ("configuration",)  # columns whose values are words; all others hold numbers


def first_cells(text: str, layout: TextLayout) -> Sequence[str]:
    """Return the values of the first line that may hold some."""
    lines = text.splitlines()[layout.first : layout.first + 1]
    return [cell.strip() for line in lines for cell in line.split(layout.delimiter)]


def likely(
    missing: str, unused: Sequence[tuple[int, SplitName]], cells: Sequence[str]
) -> list[int]:
    """Return the places of the columns that may be the missing one, by name, unit and values.

    A column of words is likely where words are missing, and no other kind of name is needed.
    """
    return [
        index
        for index, name in unused
        if _has_kind(missing, cells[index] if index < len(cells) else "")
        and (missing in _WORDS or _fits(name, missing))
    ]


def _has_kind(missing: str, cell: str) -> bool:
    """Whether a value is of the kind that the missing column has."""
    return not cell or is_number(cell) == (missing not in _WORDS)


def _fits(name: SplitName, missing: str) -> bool:
    """Whether the unit is one of the missing column, or the name is like it."""
    if name.unit is not None and not fits(name.unit, missing):
        return False
    return name.unit is not None or may_mean(name, missing) or _alike(name, missing)


def _alike(name: SplitName, missing: str) -> bool:
    """Whether the name is like one of the missing column, and is not that of another column."""
    if any(name.word in words_for(other) for other in KNOWN if other != missing):
        return False
    return any(
        own in name.word or difflib.SequenceMatcher(None, name.word, own).ratio() >= _ALIKE
        for own in words_for(missing)
        if len(own) >= _LONG
    )
