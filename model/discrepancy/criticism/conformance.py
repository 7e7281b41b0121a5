"""Conformance of a verdict check: `faults` returns what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterator

from model.discrepancy.criticism.contract import VerdictCheck


def faults(check: object) -> list[str]:
    """Return what is wrong with a verdict check, a sentence each without its full stop."""
    if not isinstance(check, VerdictCheck):
        return [f"it is of type {type(check).__name__}, not a model.discrepancy.VerdictCheck"]
    return list(_description(check))


def _description(check: VerdictCheck) -> Iterator[str]:
    if not (isinstance(check.name, str) and check.name.isidentifier()):
        yield f"its name {check.name!r} must be one word of letters, digits and underscores"
    if not (isinstance(check.meaning, str) and check.meaning.strip()):
        yield "its meaning is empty"
    if not isinstance(check.order, int):  # other people's may be anything
        yield "its order must be a whole number"  # type: ignore[unreachable]
    if type(check).failures is VerdictCheck.failures:
        yield "it has no `failures`: it would pass every verdict"
