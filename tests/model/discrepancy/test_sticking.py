"""A sheet that sticks from nearly the first position on is no hysteresis of the load cell."""

from __future__ import annotations

import pytest

from benchmarks.worlds.cases import PAPER
from benchmarks.worlds.registry import world
from model.discrepancy.search.ranking import rank
from model.effects import effect
from tests.model.discrepancy.sessions import fitted


@pytest.mark.slow
def test_sticking_from_the_second_position_on_explains_more_than_a_hysteresis(monkeypatch):
    monkeypatch.setattr("benchmarks.worlds.generators._shooting_known.STUCK_FROM_M", 2.5e-3)
    base = fitted(world("shooting").measure(PAPER, {"roll_sticking": 0.2}, 5))
    both = [effect("roll_sticking"), effect("load_cell_hysteresis")]
    gain = {one.name: one.ln_bayes_factor for one in rank(base, both, locations=False)}
    assert gain["roll_sticking"] > gain["load_cell_hysteresis"] + 20.0
