"""What commands print: tables and progress on a terminal, plain lines elsewhere, or JSON."""

from __future__ import annotations

import json
import re
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, Protocol, TextIO

from rich.cells import cell_len
from rich.console import Console, JustifyMethod
from rich.table import Table

# Also with an uncertainty, an interval, a count out of another, or nothing known.
_PLAIN_NUMBER = r"[-+\N{MINUS SIGN}]?[\d.]+"
_NUMBER = re.compile(rf"-|{_PLAIN_NUMBER}( (±|to|of|x) {_PLAIN_NUMBER})?")

_FRAME = 3  # of a column: a line and a space at each side
_TELLING = 0.1  # share of a job that tells how long the rest takes
_SHORT_S = 15.0
# The terminal on which a bar is drawn now: only by this does a line not end up behind the bar.
_with_a_bar: list[Console] = []
_json_alone: list[TextIO] = []  # standard output, while it is kept for JSON


class _Terminal(Console):
    def on_broken_pipe(self) -> None:
        """Leave it to the caller: rich would end the program, and a run with it."""
        raise BrokenPipeError


def console() -> Console:
    """Return standard output; in a pipe without colour and without wrapping."""
    return _terminal(soft_wrap=not sys.stdout.isatty())


def _terminal(*, stderr: bool = False, soft_wrap: bool = False) -> Console:
    """Return a terminal that prints what it is given: no [markup], no :emoji: in anybody's name."""
    return _Terminal(stderr=stderr, soft_wrap=soft_wrap, highlight=False, markup=False, emoji=False)


def say(text: str = "") -> None:
    """Print one line to standard output."""
    console().print(text)


def warn(text: str) -> None:
    """Print one line to standard error; above the progress bar, where one is drawn."""
    terminal = _with_a_bar[-1] if _with_a_bar else _terminal(stderr=True)
    with suppress(OSError):  # of a terminal that has been closed: the job continues
        terminal.print(text, soft_wrap=True)


def print_json(value: Any) -> None:
    """Print one JSON object to standard output; NaN and infinities become null."""
    _print_json(value, indent=2)


def print_json_line(value: Any) -> None:
    """Print one JSON object to a line of standard output."""
    _print_json(value, indent=None)


def _print_json(value: Any, *, indent: int | None) -> None:
    from labrig.serialise import finite  # slow to import

    stdout = _json_alone[-1] if _json_alone else sys.stdout
    stdout.write(json.dumps(finite(value), indent=indent, allow_nan=False) + "\n")


@contextmanager
def json_alone() -> Iterator[None]:
    """Keep standard output for JSON: what else is printed goes to standard error.

    A part of another distribution may print whatever it likes, and a program reads the JSON.
    """
    stdout = sys.stdout
    _json_alone.append(stdout)
    sys.stdout = sys.stderr
    try:
        yield
    finally:
        sys.stdout = stdout
        _json_alone.remove(stdout)


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table: drawn on a terminal, aligned text elsewhere, numbers to the right."""
    cells = [[str(cell) for cell in row] for row in rows]
    if sys.stdout.isatty():
        _draw(title, columns, cells)
    else:
        for line in plain_table(title, columns, cells):
            say(line)


def _draw(title: str, columns: Sequence[str], rows: list[list[str]]) -> None:
    terminal = console()
    widths = _widths(list(zip(columns, *rows, strict=True)), terminal.width)
    if widths is None:
        for line in _row_by_row(title, columns, rows):
            say(line)
        return
    table = Table(title=title, title_justify="left", title_style="bold")
    for number, (column, width) in enumerate(zip(columns, widths, strict=True)):
        side: JustifyMethod = "right" if _holds_numbers(rows, number) else "left"
        table.add_column(column, justify=side, width=width)
    for row in rows:
        table.add_row(*row)
    terminal.print(table)


def _widths(cells: list[tuple[str, ...]], width: int) -> list[int] | None:
    """Return how wide the columns are drawn, each at least as its longest word.

    None where the terminal is too narrow for that: words and numbers would be cut.
    """
    room = width - _FRAME * len(cells) - 1
    least = [max(cell_len(word) for cell in column for word in cell.split() or [""])
             for column in cells]  # fmt: skip
    wanted = [max(map(cell_len, column)) - word for column, word in zip(cells, least, strict=True)]
    spare = room - sum(least)
    if spare < 0:
        return None
    share = min(1.0, spare / max(1, sum(wanted)))
    return [word + int(share * more) for word, more in zip(least, wanted, strict=True)]


def _row_by_row(title: str, columns: Sequence[str], rows: list[list[str]]) -> Iterator[str]:
    """Yield the lines of a table that no line of the terminal holds: one for each cell."""
    width = max(map(len, columns))
    yield title
    for row in rows:
        yield from (f"{column:<{width}}  {cell}" for column, cell in zip(columns, row, strict=True))
        yield ""


def plain_table(title: str, columns: Sequence[str], rows: list[list[str]]) -> list[str]:
    """Return the lines of a table as aligned text."""
    widths = [max(len(row[i]) for row in [list(columns), *rows]) for i in range(len(columns))]
    right = [_holds_numbers(rows, i) for i in range(len(columns))]

    def line(cells: Sequence[str]) -> str:
        padded = [
            cell.rjust(width) if to_right else cell.ljust(width)
            for cell, width, to_right in zip(cells, widths, right, strict=True)
        ]
        return "  ".join(padded).rstrip()

    rule = "  ".join("-" * width for width in widths)
    return [title, line(columns), rule, *(line(row) for row in rows), ""]


def _holds_numbers(rows: list[list[str]], column: int) -> bool:
    """Return whether most cells of a column are numbers; the first column names the row."""
    cells = [row[column] for row in rows if row[column]]
    numbers = [cell for cell in cells if _NUMBER.fullmatch(cell)]
    return column > 0 and 2 * len(numbers) > len(cells)


class Advance(Protocol):
    """Reports how far a job is: a fraction from 0 to 1, and what is being done."""

    def __call__(self, fraction: float, text: str, *, last: bool = False) -> None:
        """Report the progress; called from time to time, returns at once.

        `last`: how the job ended, which is printed wherever it ended.
        """


@contextmanager
def progress(title: str, *, estimated: bool = True) -> Iterator[Advance]:
    """Draw a progress bar on a terminal; elsewhere print a plain line at each tenth.

    With `estimated`, how long the job still takes is added; without, its texts say so themselves.
    """
    if not sys.stderr.isatty():
        yield _PlainProgress(title, estimated=estimated)
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn())
    left = (TimeRemainingColumn(),) if estimated else ()
    terminal = _terminal(stderr=True)
    bar = Progress(*columns, *left, console=terminal, transient=True)
    task = bar.add_task(title, total=1.0)

    def advance(fraction: float, text: str, *, last: bool = False) -> None:
        bar.update(task, completed=fraction, description=f"{title}: {text}" if text else title)
        if last:  # the bar is removed with its line
            warn(_line(title, fraction, text))

    _with_a_bar.append(terminal)
    try:
        with suppress(OSError):  # as above
            bar.start()
        yield advance
    finally:
        with suppress(OSError):
            bar.stop()
        _with_a_bar.remove(terminal)


class _PlainProgress:
    def __init__(self, title: str, *, estimated: bool) -> None:
        self._title, self._estimated = title, estimated
        self._tenth = -1
        self._began_s = time.monotonic()

    def __call__(self, fraction: float, text: str, *, last: bool = False) -> None:
        tenth = int(fraction * 10 + 1e-9)
        if last:
            warn(_line(self._title, fraction, text))
        elif tenth > self._tenth:
            self._tenth = tenth
            taken_s = time.monotonic() - self._began_s
            left = time_left(taken_s, fraction) if self._estimated else ""
            warn(_line(self._title, tenth / 10, text) + left)


def time_left(taken_s: float, fraction: float) -> str:
    """Return about how long a job still takes; empty where it is short or nobody can know."""
    if fraction < _TELLING or fraction >= 1.0:
        return ""
    left_s = taken_s * (1.0 - fraction) / fraction
    if left_s < _SHORT_S:
        return ""
    if left_s < 90.0:
        return f" - about {10 * round(left_s / 10)} s left"
    return f" - about {round(left_s / 60)} min left"


def _line(title: str, fraction: float, text: str) -> str:
    return f"{title}: {100 * fraction:.0f} %{' - ' + text if text else ''}"
