"""Ask a part of another distribution: what it raises costs no verdict, and is told."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from typing import TypeVar

from model.plugins import PluginWarning, place_of

T = TypeVar("T")


def answers_of(
    whose: str, kind: type[T], ask: Callable[[], Iterable[T]], without: str
) -> list[T] | None:
    """Return what a part yields; None, after a warning, where it fails.

    `whose`: the part and its distribution, for the warning; `without`: what is done without it.
    """
    try:
        found = list(ask())
        wrong = next((one for one in found if not isinstance(one, kind)), None)
        if wrong is not None:
            raise TypeError(f"it yielded {type(wrong).__name__}, not a {kind.__name__}")
    except (Exception, SystemExit) as error:  # noqa: BLE001 - other people's code may raise anything
        raised = f"{type(error).__name__}: {error}{place_of(error)}"
        text = f"{whose} failed with {raised}; {without} without it."
        warnings.warn(" ".join(text.split()), PluginWarning, stacklevel=3)
        return None
    return found
