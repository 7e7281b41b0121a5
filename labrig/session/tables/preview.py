"""How a table was understood, in words: for whoever is to agree before it is used."""

from __future__ import annotations

import math
from collections.abc import Sequence

from labrig.session.tables.csv_rows import TextTable
from labrig.session.tables.text.layout import COMMA, IN_WORDS
from labrig.session.tables.text.meaning import ColumnMeaning, How, stated
from labrig.session.tables.text.names import POSITION

COLUMNS = ("column in the file", "is", "known by", "from", "to", "negative", "zero", "positive")
_MOST_WORDS = 4  # different words of a column that are shown


def heading(table: TextTable) -> str:
    """Return how a file is written: letters, separators, decimals, where its table is."""
    layout, count = table.layout, len(table.lines)
    parts = [
        f"{count} row{'' if count == 1 else 's'}",
        table.encoding,
        f"{'spaces' if layout.spaces else IN_WORDS[layout.delimiter]} between columns",
    ]
    if layout.delimiter != COMMA:
        parts.append(f"decimal {'comma' if table.decimal_comma else 'point'}")
    if layout.header < 0:
        parts.append("no names of columns, which are numbered")
    elif layout.header:
        parts.append(f"names in line {layout.header + 1}")
    return f"{table.path}: {', '.join(parts)}"


def rows(table: TextTable) -> list[list[str]]:
    """Return a row of `COLUMNS` for each column of a file, and for each value that is stated."""
    found = [_row(table, one) for one in table.meanings if one.name or one.means]
    stated = [["", name, "--value", text, *[""] * 4] for name, text in table.values.items()]
    return found + stated


def remarks(table: TextTable) -> list[str]:
    """Return what is assumed without a column that says it, a sentence each."""
    found = []
    if table.kind == "forces" and not table.has("reading"):
        found.append("No column reading: the lines are taken in the order of time.")
    if table.kind == "curves" and not table.has("point"):
        found.append("No column point: the lines of a curve are taken from the clamp on.")
    if table.has("sd_mN") and not table.has("mean_of"):
        found.append("No column mean_of: sd_mN is taken for the uncertainty of force_mN itself.")
    return found


def in_one_line(table: TextTable) -> str:
    """Return how a table was understood that is not written as labrig writes it; empty: it is."""
    if table.as_ours:
        return ""
    other = [
        f"{one.name} is {one.means}{_of_angle(table, one)}"
        for one in table.meanings
        if _is_renamed(one)
    ]
    unused = [one.name for one in table.meanings if not one.means and one.name]
    parts = [heading(table), *other]
    if unused:
        parts.append(f"not used: {', '.join(unused)}")
    return "; ".join(parts) + "."


def _is_renamed(one: ColumnMeaning) -> bool:
    return bool(one.means) and one.how is not How.NAMED


def _times(table: TextTable, one: ColumnMeaning) -> str:
    """Return what the numbers of the file are multiplied by; empty: nothing."""
    return f", times 1e{one.exponent}" if one.exponent else _of_angle(table, one)


def _of_angle(table: TextTable, one: ColumnMeaning) -> str:
    if one.factor is None:
        return ""
    if one.means == POSITION and table.arc_radius_m is not None:
        return f", angle times R = {1e3 * table.arc_radius_m:g} mm"
    return f", times {one.factor:.6g}"


def _row(table: TextTable, one: ColumnMeaning) -> list[str]:
    if not one.means:
        return [one.name, "", str(one.how), *[""] * 5]
    is_what = f"{one.means}{_times(table, one)}"
    known = f"a guess: {stated(one)}" if one.how is How.GUESSED else str(one.how)
    texts = [row[one.index] for row in table.cells]
    return [one.name, is_what, known, *_range(texts)]


def _range(texts: Sequence[str]) -> list[str]:
    """Return the smallest and largest number, and how many are below, at and above 0."""
    own = [text for text in texts if text]
    try:
        numbers = [float(text) for text in own]
    except ValueError:
        words = list(dict.fromkeys(own))
        more = ", ..." if len(words) > _MOST_WORDS else ""
        return [", ".join(words[:_MOST_WORDS]) + more, *[""] * 4]
    numbers = [value for value in numbers if math.isfinite(value)]
    if not numbers:
        return [""] * 5
    below, above = (sum(sign * value > 0 for value in numbers) for sign in (-1, 1))
    signs = [str(below), str(len(numbers) - below - above), str(above)]
    return [f"{min(numbers):g}", f"{max(numbers):g}", *signs]
