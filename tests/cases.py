"""Cases of which `make test` tries a few, and `make test-all` all."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

PARAM = type(pytest.param())


def few(cases: Iterable[Any], *kept: Any, first: int = 1) -> list[Any]:
    """The cases in their order; all but those that are kept, or but the first, are thorough."""
    cases = list(cases)
    assert all(case in cases for case in kept), f"one of {kept} is no case"
    stays = [case in kept if kept else number < first for number, case in enumerate(cases)]
    return [case if here else _thorough(case) for case, here in zip(cases, stays, strict=True)]


def _thorough(case: Any) -> Any:
    if isinstance(case, PARAM):
        return pytest.param(*case.values, marks=[*case.marks, pytest.mark.thorough], id=case.id)
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.thorough)
