"""A table: what the command line prints and the report shows."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Table:
    """Cells as text; the first column names the row. `note` is a sentence under the table."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = field(default="")
    quoted: frozenset[int] = frozenset()  # columns that are the paper's, not this session's


def number(value: float | None, digits: int = 3) -> str:
    """A number to so many significant digits; a dash for what is not known."""
    if value is None or value != value:
        return "-"
    return f"{value:.{digits}g}"


def fixed(value: float | None, decimals: int) -> str:
    """A number with so many decimals; a dash for what is not known."""
    if value is None or value != value:
        return "-"
    return f"{value:.{decimals}f}"
