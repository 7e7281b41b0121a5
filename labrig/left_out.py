"""Parts of other distributions that were left out: who wants to know of them is told, each once."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

# `drivers`, `model` and `sim_hardware` have a warning of this name each. Comparing the classes
# would import all three, which takes longer than the start of the program.
_PART_LEFT_OUT = "PluginWarning"

_lock = threading.Lock()
_known: list[str] = []
_told: list[Callable[[str], None]] = []


def is_left_out(category: type[Warning]) -> bool:
    """Whether a warning says that a part is left out."""
    return category.__name__ == _PART_LEFT_OUT


def same_title(one: str, other: str) -> bool:
    """Whether two titles read alike: of two parts that have them the later one is left out."""
    return " ".join(one.split()).casefold() == " ".join(other.split()).casefold()


def note(text: str) -> None:
    """Keep the sentence, and tell who listens; the same one again is no news."""
    with _lock:
        if text in _known:
            return
        _known.append(text)
        told = list(_told)
    for tell in told:
        tell(text)


@contextmanager
def told_of(tell: Callable[[str], None]) -> Iterator[None]:
    """Call `tell` with every sentence that this process knows of, now and later.

    A folder is read once in a process, so what was found before must not be lost.
    """
    with _lock:
        _told.append(tell)
        before = list(_known)
    for text in before:
        tell(text)
    try:
        yield
    finally:
        with _lock:
            _told.remove(tell)


def listen() -> None:
    """Note every such warning of this process from now on; others go Python's way."""
    as_before = warnings.showwarning

    def show(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if is_left_out(category):
            note(str(message))
        as_before(message, category, filename, lineno, file, line)

    warnings.showwarning = show
