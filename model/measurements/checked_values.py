"""Values that somebody gives in Python, each refused in one sentence that names it."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Iterable

import numpy as np

from model.measurements.data import FloatArray, ModelError


def require_number(
    name: str, value: object, *, at_least: float | None = None, above: float | None = None
) -> None:
    """Raise ModelError for what is no finite number, or is too small a one."""
    if not is_number(value):
        raise ModelError(f"{name} {shown(value)}: a number is needed")
    found = float(value)  # type: ignore[arg-type]  # it is a number
    if not math.isfinite(found):
        raise ModelError(f"{name} {found:g}: a finite number is needed")
    if at_least is not None and found < at_least:
        raise ModelError(f"{name} {found:g}: a number from {at_least:g} is needed")
    if above is not None and found <= above:
        raise ModelError(f"{name} {found:g}: a number above {above:g} is needed")


def require_whole_number(name: str, value: object, *, at_least: int) -> None:
    """Raise ModelError for what is no whole number from `at_least` on."""
    require_number(name, value, at_least=at_least)
    if not isinstance(value, int | np.integer):
        raise ModelError(f"{name} {shown(value)}: a whole number is needed")


def require_truth(name: str, value: object) -> None:
    """Raise ModelError for what is neither True nor False: the text "no" would count as True."""
    if not isinstance(value, bool | np.bool_):
        raise ModelError(f"{name} {shown(value)}: True or False is needed")


def row(name: str, values: object) -> FloatArray:
    """Return a row of numbers. Raises ModelError for what is none."""
    try:
        found = np.asarray(values)
        if found.ndim != 1 or found.dtype.kind not in "fiu":
            raise TypeError
    except (TypeError, ValueError):  # also rows of different lengths
        raise ModelError(f"{name} {shown(values)}: a row of numbers is needed") from None
    return found.astype(np.float64)


def require_pair(name: str, values: object) -> None:
    """Raise ModelError for what is no pair of equally long rows, the first of them rising."""
    rows = list(values) if isinstance(values, Iterable) and not isinstance(values, str) else []
    if len(rows) != 2:
        raise ModelError(f"{name} {shown(values)}: a pair of equally long rows is needed")
    places, found = row(f"{name}[0]", rows[0]), row(f"{name}[1]", rows[1])
    if len(places) != len(found) or not len(places):
        raise ModelError(f"{name}: {len(places)} places and {len(found)} values do not go together")
    if not np.isfinite([places, found]).all() or np.any(np.diff(places) <= 0.0):
        raise ModelError(f"{name}: finite numbers are needed, the first row rising")


def is_number(value: object) -> bool:
    """Whether it is a real number, of Python or NumPy; True and the text of a number are none."""
    one = isinstance(value, int | float | np.integer | np.floating)
    return one and not isinstance(value, bool)


def shown(value: object) -> str:
    """Return a value in a sentence, shortened, in one line."""
    return " ".join(reprlib.repr(value).split())
