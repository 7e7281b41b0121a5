"""Tables as numpy.savetxt writes them: columns with spaces between, names behind '#'."""

from __future__ import annotations

import re

from labrig.session.tables.text.layout import TAB, is_number

_MARK = "#"
_OTHER_SEPARATORS = re.compile(r"[;\t]")
_WIDE = re.compile(r"\s{2,}")
_FEWEST_NUMBERS = 2


def without_marks(text: str) -> str:
    """Return a text without the '#' before the lines that it begins with."""
    if not text.startswith(_MARK):
        return text
    lines = text.split("\n")
    for at, line in enumerate(lines):
        if not line.startswith(_MARK):
            break
        lines[at] = line.lstrip(_MARK).strip(" ")
    return "\n".join(lines)


def tabs_for_spaces(text: str) -> tuple[str, bool]:
    """Return a text with tabs between columns that spaces separate, and whether they do.

    The last line says so: numbers with nothing but spaces between. Names may hold single spaces
    where two or more separate them. Other lines stay as they are.
    """
    width = _numbers_with_spaces(text.rstrip().rpartition("\n")[2])
    if not width:
        return text, False
    return "\n".join(_with_tabs(line, width) for line in text.split("\n")), True


def _numbers_with_spaces(line: str) -> int:
    """Return how many columns a line has that spaces separate; 0 where something else does."""
    cells = line.split()
    numbers = sum(map(is_number, cells))
    if _OTHER_SEPARATORS.search(line) or numbers < max(_FEWEST_NUMBERS, len(cells) - 1):
        return 0
    return len(cells)


def _with_tabs(line: str, width: int) -> str:
    for cells in (_WIDE.split(line.strip()), line.split()):
        if len(cells) == width:
            return TAB.join(cells)
    return line
