"""An elongation that bends, and is drawn straight in the picture, has a name."""

from __future__ import annotations

import pytest

from benchmarks.worlds.cases import PAPER
from benchmarks.worlds.registry import world
from model.discrepancy import diagnose

pytestmark = pytest.mark.thorough


def test_an_elongation_that_is_drawn_straight_is_named():
    made = world("shooting").measure(PAPER, {"bar_drawn_on": 2.6e-3}, 9602)
    found = diagnose(made)
    assert [one.name for one in found.effects] == ["elongation_flexibility"]
    named = found.effects[0]
    assert named.confidence > 0.9
    assert named.choices["in_the_joint"].value == 2.0
    assert "straight" in named.choices["in_the_joint"].meaning
    # the compliance grows along it threefold, from half of this on
    assert named.parameters["relative_compliance"].value == pytest.approx(2.6e-3, rel=0.5)
