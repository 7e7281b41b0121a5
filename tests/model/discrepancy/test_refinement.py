"""Which of the fits of an effect's shapes is taken."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.discrepancy.search import forward_selection
from model.discrepancy.search.ranking import rank
from model.discrepancy.search.refinement import best_candidates, fits, other_starts
from model.discrepancy.search.refinement.best_candidates import refine_best
from model.discrepancy.search.refinement.fits import preferred, refined, settled
from model.discrepancy.verdict.messages import cut_short
from model.effects import effect
from model.effects.conformance import plausible
from model.identification.likelihood import mixed_model_fit
from model.identification.likelihood.mixed_model_fit import approach
from model.identification.likelihood.model_state import NEAR, FitPlace, Found
from tests.model.discrepancy.sessions import FALLING, base_fit

GOOD, BETTER, BEST = 103.0, 100.0, 80.0  # deviances: the first two are about as good


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ((GOOD, 0.01), (BETTER, 0.3)),  # what needs no deviation from its form
        ((BETTER, 0.1), (GOOD, 0.3)),
        ((BEST, 0.3), (BETTER, 0.01)),  # what explains more
        ((BETTER, 0.7), (BEST, 0.8)),  # what is not mostly deviation
    ],
)
def test_of_shapes_that_explain_as_much_the_one_nearest_to_its_form_is_taken(one, other):
    assert preferred(one, other)
    assert not preferred(other, one)


def place(theta: float, value: float, sigma: float) -> FitPlace:
    one = effect("roll_friction")
    values = {"long": {**plausible(one), "coefficient": value}}
    found = Found(effect=one, values=values, sigma={"long": {"coefficient": sigma}})
    return FitPlace(theta=np.array([theta]), found=(found,), log_sigma=np.zeros(1))


def test_places_are_the_same_within_a_part_of_their_uncertainty():
    here, sigma = place(1.0, 0.05, 0.01), np.array([2.0])
    assert here.near(place(1.0 + 1.9 * NEAR, 0.05 + 0.009 * NEAR, 0.01), sigma)
    assert not here.near(place(1.0 + 2.1 * NEAR, 0.05, 0.01), sigma)
    assert not here.near(place(1.0, 0.05 + 0.011 * NEAR, 0.01), sigma)
    certain = place(1.0, 0.05, 0.0)  # a value that is tried, not fitted
    assert certain.near(certain, sigma)
    assert not certain.near(place(1.0, 0.051, 0.0), sigma)


@pytest.mark.thorough
def test_a_fit_that_goes_to_and_fro_or_is_worth_nothing_ends(monkeypatch):
    base = base_fit()
    monkeypatch.setattr(mixed_model_fit, "SMALL", 0.0)  # it never comes to rest
    some = len(list(approach(base.problem, base.theta)))
    assert some == mixed_model_fit.MANY + 1
    monkeypatch.setattr(mixed_model_fit, "LITTLE", -np.inf)
    worthless = base.deviance - 100.0
    assert len(list(approach(base.problem, base.theta, worthless=worthless))) == some
    assert len(list(approach(base.problem, base.theta))) == mixed_model_fit.ROUNDS + 1


@pytest.mark.thorough
@pytest.mark.slow
def test_a_fit_of_an_effect_may_begin_where_it_is_known_and_ends_at_the_same_place(monkeypatch):
    base, one = base_fit(FALLING), effect("nonuniform_eibm")
    ranking = [c for c in rank(base, [one]) if c.known]
    first = refine_best(base, ranking)[0]
    assert first.fitted is not None
    steps = []
    spy = mixed_model_fit._Iteration.of
    monkeypatch.setattr(
        mixed_model_fit._Iteration, "of", staticmethod(lambda *a: steps.append(0) or spy(*a))
    )
    again = refined(replace(base), replace(first, fitted=None, tried=()), (first.score,),
                    first.fitted)  # fmt: skip
    assert again.fitted is not None
    # no worse, and by no more better than a fit may leave at its end
    assert -1e-3 < first.fitted.deviance - again.fitted.deviance < mixed_model_fit.LITTLE
    assert len(steps) <= 2


@pytest.mark.slow
def test_the_same_candidates_of_the_same_fit_are_ranked_once():
    base, some = base_fit(), [effect("gravity"), effect("clamp_angle")]
    first = rank(base, some)
    assert all(a is b for a, b in zip(rank(base, some), first, strict=True))
    assert rank(base, some[:1])[0] is not first[0]


@pytest.mark.slow
def test_a_name_too_weak_for_any_verdict_is_not_fitted_from_other_beginnings(monkeypatch):
    base, jointly = base_fit(), [1.0]  # evidence with the scatter estimated from the usual one on
    monkeypatch.setattr(best_candidates, "_foremost", list)
    monkeypatch.setattr(best_candidates, "rescored", lambda *_: (jointly[0], base.solution))
    one, other = rank(base, [effect("gravity"), effect("clamp_angle")], locations=False)[:2]

    def promising(ranked, top=100.0):
        done = [replace(one, ln_bayes_factor=top), replace(other, ln_bayes_factor=1.0)]
        return best_candidates._promising(base, done, {one.name: top, other.name: ranked}, top)

    both = {one.name, other.name}
    assert promising(1.0) == {one.name}
    assert promising(31.0) == both  # a straight line leads to more than its fit
    assert promising(1.0, top=29.0) == both  # nothing is clear
    jointly[0] = 31.0
    assert promising(1.0) == both


@pytest.mark.slow
def test_a_fit_that_loses_what_a_straight_line_promised_begins_elsewhere(monkeypatch):
    base = base_fit(FALLING)
    ranked = [c for c in rank(base, [effect("nonuniform_eibm")]) if c.known]
    promised = ranked[0].ln_bayes_factor
    assert promised > 20.0
    ended = []
    spy = fits.settled

    def first_at_a_wrong_place(*args, **limits):
        there = spy(*args, **limits)
        ended.append(there)
        return replace(there, deviance=base.deviance + 30.0) if len(ended) == 1 else there

    for where in (fits, other_starts):
        monkeypatch.setattr(where, "settled", first_at_a_wrong_place)
    monkeypatch.setattr(fits, "strained", lambda _fit: False)  # nor does the scatter tell
    best = refine_best(base, [replace(c, shapes=()) for c in ranked])[0]
    assert len(best.tried) > 1
    assert best.ln_bayes_factor == pytest.approx(promised, rel=0.25)


@pytest.mark.slow
def test_where_a_deviation_takes_the_place_of_an_effect_its_own_form_is_fitted_too(monkeypatch):
    base = base_fit(FALLING)
    ranked = [c for c in rank(base, [effect("nonuniform_eibm")]) if c.known]
    spy = fits.form_share

    def loose_where_it_may_differ(there, index):
        return spy(there, index) if there.found[index].form < 1.0 else 0.9

    for where in (fits, other_starts):
        monkeypatch.setattr(where, "form_share", loose_where_it_may_differ)
    best = refine_best(base, [replace(c, shapes=()) for c in ranked])[0]
    assert best.fitted is not None
    assert best.fitted.found[-1].form == other_starts.STRICT
    assert best.ln_bayes_factor == pytest.approx(ranked[0].ln_bayes_factor, rel=0.25)


@pytest.mark.slow
def test_a_fit_that_does_not_settle_ends_at_the_best_of_its_places(monkeypatch):
    base = base_fit()
    monkeypatch.setattr(mixed_model_fit, "SMALL", 0.0)  # it never comes to rest
    monkeypatch.setattr(mixed_model_fit, "LITTLE", -np.inf)
    monkeypatch.setattr(mixed_model_fit._Iteration, "worse_than", lambda *_: False)
    step, turn = mixed_model_fit._Iteration.end, []

    def astray(self):
        """Away from where the fit is, after two good steps."""
        theta, found, moves = step(self)
        turn.append(0)
        return (theta if len(turn) < 3 else self.at.theta + 0.05), found, moves

    monkeypatch.setattr(mixed_model_fit._Iteration, "end", astray)
    *places, last = approach(base.problem, base.theta)
    assert len(places) == mixed_model_fit.ROUNDS
    sigma = np.sqrt(np.diag(base.solution.covariance))
    assert np.max(np.abs(last.theta - base.theta) / sigma) < 0.1
    assert np.max(np.abs(places[-1].theta - base.theta) / sigma) > 1.0


@pytest.mark.slow
def test_a_fit_that_was_given_up_is_not_the_fit_of_a_caller_with_another_limit(monkeypatch):
    base = replace(base_fit(), linear=replace(base_fit().linear, at_states={}))
    limits = []
    real = fits.fit_mixed_model

    def spy(*a, worthless):
        limits.append(worthless)
        return real(*a, worthless=worthless)

    monkeypatch.setattr(fits, "fit_mixed_model", spy)
    low, high = base.deviance - 100.0, base.deviance + 100.0
    given_up = settled(base, base.theta, (), None, low)
    assert settled(base, base.theta, (), None, low) is given_up
    whole = settled(base, base.theta, (), None)
    assert whole is not given_up
    # one that was not given up is everybody's
    assert settled(base, base.theta, (), None, high) is whole
    assert settled(base, base.theta, (), None, low) is whole
    assert limits == [low, np.inf]


@pytest.mark.thorough
def test_a_search_ends_after_so_many_solutions_and_says_so(monkeypatch):
    base, some = base_fit(FALLING), [effect("nonuniform_eibm"), effect("gravity")]
    whole = forward_selection.search(base.problem, base.theta, some, 6.0)
    assert len(whole.steps) == 2  # the second finds nothing further
    assert not list(cut_short(whole.base.problem.effort))
    again = forward_selection.search(base.problem, base.theta, some, 6.0)
    solutions = again.base.problem.effort.solutions  # each search has its own count
    assert solutions == whole.base.problem.effort.solutions > 3
    monkeypatch.setattr(forward_selection, "MOST_SOLUTIONS", 3)
    short = forward_selection.search(base.problem, base.theta, some, 6.0)
    assert [one.name for one in short.chosen] == ["nonuniform_eibm"]
    assert len(short.steps) == 1
    (note,) = cut_short(short.base.problem.effort)
    assert "after 3 solutions of the model" in note
    assert "--most-effects (most_effects) goes on" in note
    longer = forward_selection.search(base.problem, base.theta, some, 6.0, most=300)
    assert longer.base.problem.effort.most == 300  # in proportion to the usual 3 effects
    assert len(longer.steps) == len(whole.steps)
