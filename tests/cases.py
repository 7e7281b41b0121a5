"""Cases of which `make test` tries a few, and `make test-all` all."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def few(cases: Iterable[Any], *kept: Any) -> list[Any]:
    """The cases in their order; all but those that are kept (or but the first one) are thorough."""
    cases = list(cases)
    lacking = [case for case in kept if case not in cases]
    assert not lacking, f"no such cases: {lacking}"
    return [case if case in (kept or cases[:1]) else _thorough(case) for case in cases]


def _thorough(case: Any) -> Any:
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.thorough)
