"""What the output guard leaves beside a session whose program could not tell its own end."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from drivers.safe_shutdown import Safety, SafetyReport

_LONGEST = 65536


@dataclass(frozen=True)
class GuardReport:
    """That the guard has ended a run, why, and what it has read back."""

    is_safe: bool
    text: str  # a sentence, without its full stop


def guard_report_path(session: Path) -> Path:
    """Where the guard leaves its report. A program that ends its session itself removes it."""
    return session.with_name(session.name + ".guard.json")


def forget_guard_report(session: Path) -> None:
    """Remove the report of a run that is over; nothing hangs on it, least of all making safe."""
    with suppress(OSError):
        guard_report_path(session).unlink(missing_ok=True)


def read_guard_report(session: Path) -> GuardReport | None:
    """Return the report; None when there is none, or what is there is not whole (yet)."""
    try:
        with guard_report_path(session).open("rb") as file:
            facts = json.loads(file.read(_LONGEST))
        found = SafetyReport(Safety(facts["state"]), facts["read_back_V"], tuple(facts["failures"]))
        text = f"the output guard has ended this run ({facts['why']}); {found.text}"
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return GuardReport(found.is_safe, text)
