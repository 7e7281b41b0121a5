"""How far a job is, for whoever shows it."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float, str], None]  # how much is done, 0 to 1, and what is being done


def silent(_share: float, _text: str) -> None:
    """Report no progress."""
