"""A table: what the command line prints and the report shows."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class Table:
    """Cells as text; the first column names the row. `note` is a sentence under the table."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = field(default="")
    quoted: frozenset[int] = frozenset()  # columns that are the paper's, not this session's
    text: bool = False  # cells are sentences rather than numbers: aligned left, and wrapped


def number(value: float | None, digits: int = 3) -> str:
    """Return a number to so many significant digits; a dash for what is not known."""
    if value is None or value != value:
        return "-"
    from model.measurements import in_digits  # which imports NumPy

    return in_digits(value, digits)


def fixed(value: float | None, decimals: int) -> str:
    """Return a number with so many decimals, two digits if they show none; a dash: not known."""
    if value is None or value != value:
        return "-"
    from model.measurements import in_decimals  # which imports NumPy

    return in_decimals(value, decimals)


def decimals_for(values: Iterable[float], least: int) -> int:
    """Return `least` decimals, or what shows four digits of the largest where these show one."""
    largest = max((abs(one) for one in values if math.isfinite(one)), default=0.0)
    if largest <= 0.0 or largest >= 10.0 ** (1 - least):
        return least
    return min(12, 3 - math.floor(math.log10(largest)))


def with_sigma(value: float, sigma: float) -> str:
    """Return a number and its standard uncertainty, to two digits of the latter."""
    if not math.isfinite(value):
        return "-"
    if not math.isfinite(sigma) or sigma <= 0:
        return number(value, 4)
    decimals = min(12, max(0, 1 - math.floor(math.log10(sigma))))
    return f"{value:.{decimals}f} ± {sigma:.{decimals}f}"


def interval(low: float, high: float) -> str:
    """Return an interval, to two digits of its width's tenth."""
    if not (math.isfinite(low) and math.isfinite(high)) or high <= low:
        return "-"
    decimals = min(12, max(0, 1 - math.floor(math.log10((high - low) / 3.3))))
    return f"{low:.{decimals}f} to {high:.{decimals}f}"


def volts(voltage_V: float) -> str:
    """Return a voltage with its sign, in characters that every console has."""
    from model.measurements import in_volts  # which imports NumPy

    return in_volts(voltage_V)
