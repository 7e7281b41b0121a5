"""Which tests need a package of the system, and whether they ran.

`@pytest.mark.system_package("Chromium")` names it. Such a test skips itself with a sentence where
the package is missing; the end of the run says for each package what ran and what did not.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import pytest

MARK = "system_package"


def note(item: pytest.Item) -> None:
    """Write the package into what a worker reports of a test."""
    for mark in item.iter_markers(MARK):
        item.user_properties.append((MARK, mark.args[0]))


def summary(reports: Mapping[str, Sequence[Any]]) -> list[str]:
    """Return a line for each package: how many tests ran, how many did not and why."""
    ran: Counter[str] = Counter()
    skipped: dict[str, Counter[str]] = {}
    for outcome in ("passed", "failed", "skipped"):
        for report in reports.get(outcome, ()):
            for name, package in getattr(report, "user_properties", ()):
                if name == MARK and outcome == "skipped":
                    skipped.setdefault(package, Counter())[_reason(report)] += 1
                elif name == MARK and report.when == "call":
                    ran[package] += 1
    return [
        _line(package, ran[package], skipped.get(package)) for package in sorted({*ran, *skipped})
    ]


def _line(package: str, ran: int, skipped: Counter[str] | None) -> str:
    parts = [f"{ran} ran"] if ran else []
    for reason, count in (skipped or Counter()).items():
        parts.append(f"{count} did not ({reason})")
    return f"tests that need {package}: {', '.join(parts)}"


def _reason(report: Any) -> str:
    text = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    return str(text).removeprefix("Skipped: ")
