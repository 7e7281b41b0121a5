"""One thing that was looked at: in a preflight, in a session file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Check:
    """What was found, and what was wanted. A warning is worth a word but stops nothing."""

    name: str
    ok: bool
    found: str
    wanted: str
    warning: bool = False

    @property
    def word(self) -> str:
        """For a table."""
        if not self.ok:
            return "FAILED"
        return "warning" if self.warning else "ok"

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {"name": self.name, "ok": self.ok, "found": self.found, "wanted": self.wanted}
