"""One check of a preflight or of a session file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

_SHORT = 70  # letters


def failures(checks: Iterable[Check]) -> str:
    """Return what failed, in one phrase."""
    failed = (check for check in checks if not check.ok)
    return "; ".join(c.in_words if c.is_short else f"{c.name}: {c.found}" for c in failed)


@dataclass(frozen=True, kw_only=True)
class Check:
    """What was found, and what was wanted. A warning stops nothing."""

    name: str
    ok: bool
    found: str
    wanted: str
    warning: bool = False

    @property
    def word(self) -> str:
        """Return the result as a word, for a table."""
        if not self.ok:
            return "FAILED"
        return "warning" if self.warning else "ok"

    @property
    def in_words(self) -> str:
        """Return the check as one phrase."""
        return f"{self.name}: {self.found}, wanted {self.wanted}"

    @property
    def is_short(self) -> bool:
        """Whether what was found fits into a table; a long one is a sentence of its own."""
        return len(self.found) < _SHORT

    def as_dict(self) -> dict[str, Any]:
        """Return the check for JSON."""
        return {"name": self.name, "ok": self.ok, "found": self.found, "wanted": self.wanted}
