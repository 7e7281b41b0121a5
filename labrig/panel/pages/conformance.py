"""Checks of a page; they run on other distributions' pages when these are loaded."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from drivers.kinds import call_fault

_MODES = {"rig", "sessions", "replay", "photographs"}


def faults(page: object) -> list[str]:
    """Return what is wrong with a page, a sentence each; none when it keeps the contract."""
    return list(_faults(page))


def _faults(page: object) -> Iterator[str]:
    title = getattr(page, "title", None)
    if not isinstance(title, str) or not title.strip():
        yield "its title must be a text"
    order = getattr(page, "order", None)
    if isinstance(order, bool) or not isinstance(order, int | float) or not math.isfinite(order):
        yield "its order must be a finite number"
    for name in ("modes", "opens"):
        modes = getattr(page, name, None)
        if not isinstance(modes, frozenset) or not modes <= _MODES:
            yield f"{name} must be a frozenset of {', '.join(sorted(_MODES))}"
    yield from _content_faults(page)


def _content_faults(page: object) -> Iterator[str]:
    from fastapi import APIRouter

    script, data = getattr(page, "script", None), getattr(page, "data", None)
    if script is None and data is None:
        yield "it has neither a script nor data to show"
    if script is not None and not (
        isinstance(script, Path) and script.suffix == ".js" and script.is_file()
    ):
        yield f"its script {script} must be the path of a .js file"
    if data is not None and (fault := call_fault("data", data, ("panel",))):
        yield fault
    if not isinstance(getattr(page, "router", None), APIRouter | None):
        yield "router must be a fastapi.APIRouter"
