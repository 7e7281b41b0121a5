"""What every export format must fulfil: `faults` finds nothing in a good one."""

from __future__ import annotations

from collections.abc import Iterator

from drivers.kinds import call_fault


def faults(candidate: object) -> list[str]:
    """Return what is wrong with an export format, a sentence each without its full stop."""
    return list(_faults(candidate))


def _faults(candidate: object) -> Iterator[str]:
    summary = getattr(candidate, "summary", None)
    if not isinstance(summary, str) or not summary.strip().endswith("."):
        yield "summary must be one sentence with its full stop"
    if not isinstance(getattr(candidate, "extra", None), str):
        yield "extra must be a text, empty where no package is needed"
    if fault := call_fault("write", getattr(candidate, "write", None), ("session", "folder")):
        yield fault
