"""A stage that stands elsewhere for the second sheet is no property of the rolls."""

from __future__ import annotations

import pytest

from benchmarks.worlds.cases import THOROUGH
from benchmarks.worlds.registry import world
from model.discrepancy import diagnose


@pytest.mark.slow
def test_a_stage_that_was_nudged_between_two_sheets_is_unknown_in_the_position():
    """It was called an offset of the rolls, at 0.97, which is 0 mm in one sheet and 1.9 in one."""
    found = diagnose(world("moving").measure(THOROUGH, {"nudged_stage": 1.906}, 15534104))
    assert not found.effects
    assert found.unknown is not None
    assert found.unknown.location == "position"
