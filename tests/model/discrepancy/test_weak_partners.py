"""A weak effect beside a strong one."""

from __future__ import annotations

import pytest

from benchmarks.worlds.cases import THOROUGH
from benchmarks.worlds.generators import elements
from model.discrepancy import diagnose

pytestmark = [pytest.mark.slow, pytest.mark.thorough]


def test_what_the_other_name_may_do_is_not_taken_off_twice():
    """Where the loop is uncertain, set-ups are seen to differ less, and the turn stands out."""
    hidden = {"load_cell_misalignment": 0.292, "load_cell_hysteresis": 0.259}
    found = diagnose(elements.WORLD.measure(THOROUGH, hidden, 934115802))
    assert {one.name for one in found.effects} == set(hidden)
