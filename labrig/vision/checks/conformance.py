"""Conformance of a check of a curve: `faults` returns what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterator

from labrig.vision.checks.contract import CheckStage, CurveCheck


def faults(check: object) -> list[str]:
    """Return what is wrong with a check, a sentence each without its full stop."""
    if not isinstance(check, CurveCheck):
        return [f"it is of type {type(check).__name__}, not a CurveCheck"]
    return list(_faults(check))


def _faults(check: CurveCheck) -> Iterator[str]:
    if not (isinstance(check.name, str) and check.name.isidentifier()):
        yield f"its name {check.name!r} must be one word of letters, digits and underscores"
    if not (isinstance(check.looks_at, str) and check.looks_at.strip()):
        yield "looks_at is empty"
    if not isinstance(check.order, int):  # other people's may be anything
        yield "its order must be a whole number"  # type: ignore[unreachable]
    if check.stage not in set(CheckStage):
        yield f"its stage must be one of {', '.join(CheckStage)}"
    if type(check).finding is CurveCheck.finding:
        yield "it has no `finding`: it would pass every curve"
    if not check.refusal and not check.warning:
        yield "it has neither a refusal nor a warning: it says nothing"
    if check.refusal and not (" failed: " in check.refusal and check.refusal.endswith(".")):
        yield (
            "its refusal must name the step that failed ('check of ... failed: ...') and end "
            "with a full stop"
        )
    if check.warning.endswith("."):
        yield "its warning must be without a full stop: several are joined"
