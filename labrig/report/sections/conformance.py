"""Checks of a report's section; they run on other distributions' sections when these are loaded."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from drivers.kinds import call_fault
from labrig.report.parts.section import Drawn, Folded, Section
from labrig.report.parts.table import Table

_FIGURE_NAME = re.compile(r"[a-z0-9][a-z0-9_-]*")


def faults(section: object) -> list[str]:
    """Return what is wrong with a section, a sentence each; none when it keeps the contract."""
    return list(_faults(section))


def _faults(section: object) -> Iterator[str]:
    title = getattr(section, "title", None)
    if not isinstance(title, str) or not title.strip():
        yield "its title must be a text"
    order = getattr(section, "order", None)
    if isinstance(order, bool) or not isinstance(order, int | float) or not math.isfinite(order):
        yield "its order must be a finite number"
    for name, arguments in {"applies": ("findings",), "make": ("findings", "figures")}.items():
        if fault := call_fault(name, getattr(section, name, None), arguments):
            yield fault
    names = getattr(section, "figures", None)
    if not isinstance(names, tuple) or not all(map(_is_figure_name, names)):
        yield "figures must be names of files without an ending: small letters, digits, - and _"


def _is_figure_name(name: object) -> bool:
    return isinstance(name, str) and _FIGURE_NAME.fullmatch(name) is not None


def content_faults(made: object, figures: tuple[str, ...] = ()) -> list[str]:
    """Return what is wrong with what a section's `make` returned; `figures`: names it may draw."""
    if isinstance(made, str):
        return [] if made.strip() else ["its sentence is empty"]
    if not isinstance(made, Section):
        return [f"make returned {type(made).__name__}, neither a Section nor a sentence"]
    sentences = [text for each in made.sentences for text in _text_faults("a sentence", each)]
    return sentences + [text for item in made.items for text in _item_faults(item, figures)]


def _item_faults(item: object, figures: tuple[str, ...]) -> Iterator[str]:
    if isinstance(item, Drawn):
        if item.name not in figures:
            yield f"the figure {item.name} is not among its figures"
        return
    if not isinstance(item, Table | Folded):
        yield f"{type(item).__name__} is neither a table nor a figure nor a detail"
        return
    table = item if isinstance(item, Table) else item.table
    if table is None:
        return
    of_table = f"of the table '{table.title or item.title}'"
    if any(len(row) != len(table.columns) for row in table.rows):
        yield f"a row {of_table} has not as many cells as columns"
    cells = [("a column", name) for name in table.columns]
    cells += [("a cell", cell) for row in table.rows for cell in row]
    wrong = [text for what, cell in cells for text in _text_faults(f"{what} {of_table}", cell)]
    yield from wrong[:1]  # a table of numbers has hundreds


def _text_faults(what: str, text: object) -> Iterator[str]:
    if not isinstance(text, str):
        yield f"{what} must be a text, not {text!r:.40} ({type(text).__name__})"
