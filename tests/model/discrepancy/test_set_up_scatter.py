"""What is another one in each set-up, and more so than is usual, is told as something unknown."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from benchmarks.hidden_effects.recipe import Recipe
from benchmarks.hidden_effects.sessions import hidden_session
from model.discrepancy import diagnose
from model.discrepancy.criticism.set_up_scatter import of_set_ups, unusual_set_ups
from model.measurements import Measurements
from tests.fits_unchecked import fits_unchecked
from tests.model.discrepancy.sessions import NOTHING, base_fit, fitted

TIMES = 20.0


@cache
def scattered(what: str) -> Measurements:
    """A session whose set-ups differ by more than usual in one thing."""

    def more(recipe: Recipe) -> None:
        recipe.world["scatter"][what] *= TIMES

    return hidden_session(NOTHING, more).measurements


def test_set_ups_that_differ_as_usual_are_no_evidence():
    assert unusual_set_ups(base_fit(NOTHING)) == []


@pytest.mark.slow
@pytest.mark.parametrize(("what", "location"), [("stiffness", "compliance"), ("eibm", "eibm")])
def test_it_acts_where_the_set_ups_differ(what: str, location: str):
    best = unusual_set_ups(fitted(scattered(what)))[0]
    assert (of_set_ups(best), best.score.candidate.location) == (what, location)


@pytest.mark.slow
def test_it_is_told_with_what_each_set_up_had_and_is_not_in_the_model_file():
    with fits_unchecked():
        found = diagnose(scattered("stiffness"))
    assert (found.verdict, found.effects) == ("unknown_effect", ())
    assert found.unknown is not None
    assert (found.unknown.location, found.unknown.along) == ("compliance", "position")
    assert len(found.unknown.profile) == 7  # one for each position
    assert np.max(np.abs(found.unknown.profile)) > 0.1  # of the stiffness
    assert "of its own in each set-up, with" in found.sentence
    assert found.sentence.endswith("is no chance.")
    assert found.ranking[0].why_not == "reported, at the usual scatter of set-ups"
    assert not found.model.effects
    told = found.unknown.to_json()
    assert (told["at_unit"], told["under"]) == ("mm", "")
    assert told["advice"] in found.sentence
