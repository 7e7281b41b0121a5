"""What the rolls do to the sheet, in the words of others, is told from what is not theirs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.worlds.cases import PAPER
from benchmarks.worlds.registry import world
from model.discrepancy.search.ranking import rank
from model.effects import catalogue, effect
from tests.model.discrepancy.sessions import fitted


@pytest.mark.slow
def test_sticking_from_the_second_position_on_explains_more_than_a_hysteresis(monkeypatch):
    monkeypatch.setattr("benchmarks.worlds.generators._shooting_known.STUCK_FROM_M", 2.5e-3)
    base = fitted(world("shooting").measure(PAPER, {"roll_sticking": 0.2}, 5))
    both = [effect("roll_sticking"), effect("load_cell_hysteresis")]
    gain = {one.name: one.ln_bayes_factor for one in rank(base, both, locations=False)}
    assert gain["roll_sticking"] > gain["load_cell_hysteresis"] + 20.0


@pytest.mark.slow
def test_rolls_that_pull_one_way_are_told_from_all_else():
    """No history: a generator that knows none of the sliding, or rolls that are wound up."""

    def pull(s_hat, at, coefficient):
        del at
        return np.full_like(s_hat, coefficient)

    one = world("elements")
    friction = replace(one.acts["roll_friction"], slides=pull)
    other = replace(one, acts={**one.acts, "roll_friction": friction})
    base = fitted(other.measure(PAPER, {"roll_friction": 0.3}, 5))
    first, second = rank(base, list(catalogue().values()))[:2]
    assert first.name == "roll_friction"
    assert first.ln_bayes_factor > second.ln_bayes_factor + 10.0
