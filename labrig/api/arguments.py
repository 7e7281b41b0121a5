"""Checks of arguments, for all functions of the API: one sentence that names the argument.

The command line says the option in place of the argument (`BadArgumentError.in_words`).
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from labrig.errors import BadArgumentError, type_in_words

One = TypeVar("One", bound=str | float)
Numbers = float | Sequence[float] | npt.NDArray[np.floating[Any] | np.integer[Any]]
_SHOWN = 60  # letters of a value in a sentence
_GRAM = 1e-3


def number(
    name: str,
    value: object,
    *,
    above: float | None = None,
    at_least: float | None = None,
) -> float:
    """Return a finite number that was given. Raises BadArgumentError."""
    found = _as_float(value)
    if found is None or not math.isfinite(found):
        raise BadArgumentError(f"{name} {shown(value)}: a number is needed.", name)
    if above is not None and not found > above:
        raise BadArgumentError(f"{name} {found:g}: a number above {above:g} is needed.", name)
    if at_least is not None and not found >= at_least:
        raise BadArgumentError(f"{name} {found:g}: a number from {at_least:g} is needed.", name)
    return found


def whole_number(
    name: str, value: object, *, at_least: int | None = None, at_most: int | None = None
) -> int:
    """Return a whole number that was given; 20.0 is one. Raises BadArgumentError."""
    found = number(name, value)
    if not found.is_integer():
        raise BadArgumentError(f"{name} {found:g}: a whole number is needed.", name)
    if at_least is not None and found < at_least:
        raise BadArgumentError(f"{name} {found:g}: a number from {at_least} is needed.", name)
    if at_most is not None and found > at_most:
        raise BadArgumentError(f"{name} {found:g}: a number up to {at_most} is needed.", name)
    return int(found)


def numbers(name: str, given: Numbers | None) -> list[float]:
    """Return numbers that were given alone or as a sequence. Raises BadArgumentError."""
    return [number(name, one) for one in several(given)]


def pair(name: str, given: object, wanted: str) -> tuple[list[float], list[float]]:
    """Return two equally long rows of numbers. Raises BadArgumentError, which says `wanted`."""
    rows = list(given) if isinstance(given, Iterable) and not isinstance(given, str) else []
    wrong = BadArgumentError(f"{name} {shown(given)}: {wanted}.", name)
    if len(rows) != 2 or any(isinstance(r, str) or not isinstance(r, Iterable) for r in rows):
        raise wrong
    first, second = (list(row) for row in rows)
    if len(first) != len(second) or not first or any(np.ndim(x) for x in (*first, *second)):
        raise wrong
    return [number(name, x) for x in first], [number(name, x) for x in second]


def one_of(name: str, value: object, among: Sequence[str]) -> str:
    """Return a word that was given, where it is known. Raises BadArgumentError."""
    if isinstance(value, str) and value in among:
        return value
    known = ", ".join(map(repr, among))
    raise BadArgumentError(f"{name}: {shown(value)} is not one of {known}.", name)


def elongation_kg_per_m(given: float | None) -> float | None:
    """Return the mass of a rigid elongation per length, of an argument `elongation_g_per_m`."""
    return None if given is None else _GRAM * number("elongation_g_per_m", given, above=0.0)


def check_options(options: object, kind: type, name: str, **is_given: bool) -> None:
    """Raise BadArgumentError for options of another kind, and for arguments that they hold."""
    if not isinstance(options, kind):  # a caller may give anything
        raise BadArgumentError(
            f"options: a {name} is needed, not {type_in_words(options)}; all other "
            "arguments are given by name.",
            "options",
        )
    held = [one for one, given in is_given.items() if given]
    if held:
        raise BadArgumentError(
            f"options hold {', '.join(held)}: give each once, there or as an argument.", *held
        )


def several(given: One | Sequence[One] | npt.NDArray[Any] | None) -> list[One]:
    """Return a list of what was given alone, as a sequence or not at all."""
    if given is None:
        return []
    if isinstance(given, str) or not isinstance(given, Iterable):
        return [given]
    try:
        return list(given)
    except TypeError:  # an array without axes calls itself iterable
        return [given]  # type: ignore[list-item]


def texts(given: str | Sequence[str] | None) -> list[str]:
    """Return texts that were given alone or as a sequence; a number becomes its text."""
    return [str(one) for one in several(given)]


def shown(value: object) -> str:
    """Return a value in a sentence, shortened."""
    return textwrap.shorten(repr(value), _SHOWN, placeholder=" ...")


def _as_float(value: object) -> float | None:
    """Return a number; None for what is none, such as the text of one."""
    if isinstance(value, str | bytes | bool | np.bool_):
        return None
    try:
        return float(value)  # type: ignore[arg-type]  # a caller may give anything
    except (TypeError, ValueError, OverflowError):
        return None
