"""How an object appears in a console and in a notebook: one screen, whatever it holds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

MOST_ROWS = 16  # of a table; with title, columns and notes it fits a screen of 24 lines
MOST_NOTES = 4
MOST_LETTERS = 100  # of a line
_ROUNDING = 1e-9  # what is no larger is 0
_PLAIN = 1e7  # up to here without an exponent
_CELL = 'style="text-align: {}; padding: 0 0.7em"'


def in_digits(value: float, digits: int) -> str:
    """Return a number to so many significant digits, as people read it: 1230, not 1.23e+03."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < _PLAIN else text


def in_decimals(value: float, decimals: int) -> str:
    """Return a number with so many decimals, and to two digits where these would show none."""
    shows_none = _ROUNDING < abs(value) < 0.5 * 10.0**-decimals
    return f"{value:.2g}" if shows_none else f"{value:.{decimals}f}"


def signed(value: float) -> str:
    """Return a number with its sign, 0 without: +2, 0."""
    return f"{value:+g}" if value else "0"


def in_volts(voltage_V: float) -> str:
    """Return a voltage as people read it: +2 V, 0 V."""
    return f"{signed(voltage_V)} V"


@dataclass(frozen=True)
class Summary:
    """A title, a table of text and some sentences."""

    title: str
    columns: tuple[str, ...] = ()
    rows: Sequence[tuple[str, ...]] = ()
    notes: tuple[str, ...] = ()

    def text(self) -> str:
        """Return the lines for a console."""
        rows, more = self._shown()
        lines = [_cut(self.title)]
        if self.columns:
            table = [self.columns, *rows]
            widths = [max(len(row[i]) for row in table) for i in range(len(self.columns))]
            lines += [_cut(_line(row, widths)) for row in table]
        return "\n".join([*lines, *map(_cut, self._notes(more))])

    def html(self) -> str:
        """Return the same for a notebook."""
        rows, more = self._shown()
        parts = [f"<div><strong>{escape(self.title)}</strong>"]
        if self.columns:
            head, body = _row("th", self.columns), "".join(_row("td", row) for row in rows)
            parts.append(f"<table><thead>{head}</thead><tbody>{body}</tbody></table>")
        parts += [f"<div>{escape(note)}</div>" for note in self._notes(more)]
        return "".join([*parts, "</div>"])

    def _shown(self) -> tuple[list[tuple[str, ...]], int]:
        """Return the rows that fit, and how many are left out."""
        rows = list(self.rows)
        if len(rows) <= MOST_ROWS:
            return rows, 0
        return rows[: MOST_ROWS - 1], len(rows) - MOST_ROWS + 1

    def _notes(self, more: int) -> list[str]:
        lacking = len(self.notes) - MOST_NOTES
        return [
            *([f"... {more} more rows"] if more else []),
            *self.notes[:MOST_NOTES],
            *([f"... {lacking} more notes"] if lacking > 0 else []),
        ]


class Displayed(ABC):
    """An object that shows a summary of itself; a dataclass of this kind needs `repr=False`."""

    @abstractmethod
    def summary(self) -> Summary:
        """Return what is shown of it. Must be quick: a debugger asks for it, too."""

    def __repr__(self) -> str:
        """Return the summary as text, which fits one screen."""
        return self.summary().text()

    def _repr_html_(self) -> str:
        """Return the summary for a notebook."""
        return self.summary().html()

    if not TYPE_CHECKING:  # a type checker shall still find names that are not there

        def __getattr__(self, name: str) -> object:
            """Say what the object has, where a name is guessed."""
            if name.startswith("_") or hasattr(type(self), name):  # a property that failed says why
                return object.__getattribute__(self, name)
            has = ", ".join(_public(self))
            raise AttributeError(
                f"{type(self).__name__!r} object has no attribute {name!r}; it has {has}"
            )


def _public(shown: Displayed) -> list[str]:
    """Return its names; methods with brackets."""
    names = [name for name in dir(shown) if not name.startswith("_")]
    return [f"{one}()" if callable(getattr(type(shown), one, None)) else one for one in names]


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    first, *others = zip(row, widths, strict=True)
    cells = [first[0].ljust(first[1]), *(cell.rjust(width) for cell, width in others)]
    return ("  " + "  ".join(cells)).rstrip()


def _row(element: str, cells: Sequence[str]) -> str:
    """Return a row in HTML: the first cell to the left, numbers to the right."""
    aligned = [_CELL.format("right" if i else "left") for i in range(len(cells))]
    inner = (
        f"<{element} {style}>{escape(cell)}</{element}>"
        for style, cell in zip(aligned, cells, strict=True)
    )
    return f"<tr>{''.join(inner)}</tr>"


def _cut(line: str) -> str:
    return line if len(line) <= MOST_LETTERS else f"{line[: MOST_LETTERS - 3]}..."
