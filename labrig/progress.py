"""How far a job is: what shows it, and the share of a part in the whole."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float, str], None]  # how much is done, 0 to 1, and what is being done


def silent(_share: float, _text: str) -> None:
    """Report no progress."""


def within(progress: Progress | None, low: float, high: float) -> Progress:
    """Return the progress of a part of a job, as `low` to `high` of the whole."""
    whole = progress or silent
    return lambda share, text: whole(low + (high - low) * share, text)
