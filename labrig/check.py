"""One check of a preflight or of a session file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


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

    def as_dict(self) -> dict[str, Any]:
        """Return the check for JSON."""
        return {"name": self.name, "ok": self.ok, "found": self.found, "wanted": self.wanted}
