"""What is another one in each set-up, and more so than is usual, is told as something unknown."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.hidden_effects.recipe import Recipe
from benchmarks.hidden_effects.sessions import hidden_session
from model.discrepancy import diagnose
from model.discrepancy.criticism.set_up_scatter import of_set_ups, unusual_set_ups
from model.discrepancy.verdict.inferred_form import unknown_of
from model.identification.likelihood.mixed_model import weigh
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


def test_an_eibm_of_its_own_at_each_condition_is_told_and_has_no_place_elsewhere():
    """The scatter takes it up, at 20 times its usual size: to the search nothing is missing."""
    base = base_fit(NOTHING)
    forward = base.problem.forward
    rows = np.zeros(forward.row_index.size)
    for c, state in enumerate(base.linear.states):
        at = np.nan_to_num(state.beam.stated_m)[:, None] / 0.03
        more = replace(state.beam, eibm=state.beam.eibm * (1.0 + 0.05 * np.sin(9.0 * at)))
        by = forward.configuration_models[c].change(state.beam, more, state.solved.contact)
        rows += forward.rows_of(c, state, replace(forward.no_step(c), beam=by))
    data = replace(base.linear.data, y=base.linear.data.y + forward.row_index.pad(rows))
    log_sigma = base.solution.log_sigma.copy()
    log_sigma[base.problem.noise_names().index("eibm_condition")] += np.log(TIMES)
    linear = replace(base.linear, data=data)
    fit = replace(base, linear=linear, solution=weigh(data, log_sigma))
    (found,) = unusual_set_ups(fit)
    assert (of_set_ups(found), found.name) == ("eibm_condition", "unknown:eibm")
    assert found.ln_bayes_factor > 50.0
    told = unknown_of(fit, found)
    assert np.ptp(told.profile) > 0.02  # of the EIBM
    assert "of its own at each voltage of each set-up, with 10 times" in told.depends


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
    assert "comes back with the position, or with the time, is no chance." in found.sentence
    assert found.ranking[0].why_not == "reported, at the usual scatter of set-ups"
    assert not found.model.effects
    told = found.unknown.to_json()
    assert (told["at_unit"], told["under"]) == ("mm", "")
    assert told["advice"] in found.sentence


@pytest.mark.slow
def test_a_force_that_wanders_slowly_in_each_run_goes_with_time():
    """A draught: slower than what is looked for as a period, quicker than a drift."""
    m = hidden_session(NOTHING).measurements

    def swayed(at_s: float) -> float:
        return 1.2e-4 * np.sin(at_s / 7.0) + 0.8e-4 * np.sin(at_s / 4.3)

    conditions = [
        replace(
            c,
            readings=tuple(
                replace(r, force_N=r.force_N + swayed(r.session_s or 0.0)) for r in c.readings
            ),
        )
        for c in m.conditions
    ]
    with fits_unchecked():
        found = diagnose(replace(m, conditions=tuple(conditions)))
    assert (found.verdict, found.effects) == ("unknown_effect", ())
    assert found.unknown is not None
    assert found.unknown.location == "time"
    assert "a force that wanders in the course of each run, of its own in each set-up" in (
        found.sentence
    )
