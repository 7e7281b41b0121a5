"""Which names data do not tell apart: of each session or of all, at one place or at two."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy.answers.calibrated_answers import Judged
from model.discrepancy.answers.choice_set import ChoiceSet
from model.discrepancy.answers.reported_set import of_name
from model.discrepancy.criticism.criticise import Criticism
from model.discrepancy.criticism.kinds import neighbours
from model.discrepancy.criticism.kinds.neighbours import explains_as_much, reach
from model.discrepancy.search.evidence import (
    Candidate,
    Projected,
    Score,
    candidates,
    log_prior,
    score,
    surprise,
)
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import (
    FURTHER_NAME_LN,
    NEIGHBOUR_EVIDENCE_LN,
)
from model.effects import effect
from tests.model.discrepancy.sessions import base_fit

EACH = ("session_zero", "session_position", "session_scale")
DIFFERENCES = ("session_stiffness", "session_eibm", "session_curvature")


def candidate(name: str) -> Candidate:
    one = effect(name)
    return Candidate(
        name=name, values={}, columns=np.ones((4, 1)), sizes=(1.0,), effect=one,
        location=one.location,
    )  # fmt: skip


def ranked(name: str, gain: float) -> RankedCandidate:
    own = Score(candidate=candidate(name), log_bayes=gain, amplitude=1.0, scale=1.0, length=1.0)
    return RankedCandidate(score=own, ln_bayes_factor=gain)


@pytest.mark.parametrize("name", EACH)
def test_a_value_of_each_session_says_two_things_and_is_less_likely_beforehand(name: str):
    assert log_prior(effect(name)) == -FURTHER_NAME_LN
    assert surprise(ranked(name, 1.0).score) == -FURTHER_NAME_LN


@pytest.mark.parametrize("name", [*DIFFERENCES, "camera_scale", "force_offset"])
def test_a_difference_between_sessions_or_a_value_of_all_says_one_thing(name: str):
    assert log_prior(effect(name)) == 0.0
    assert log_prior(None) == 0.0


@pytest.mark.slow
def test_evidence_counts_what_an_effect_says_beforehand():
    fitted = base_fit()
    forward = fitted.problem.forward
    projected = Projected.of(forward, fitted.linear, fitted.solution)
    (zero,) = candidates(fitted, [effect("force_offset")])
    each = replace(zero, effect=effect("session_zero"))
    apart = score(forward, projected, each).log_bayes - score(forward, projected, zero).log_bayes
    assert apart == pytest.approx(-FURTHER_NAME_LN)


def test_what_says_more_than_a_name_is_no_rival_where_the_data_speak_against_it():
    assert reach(ranked("session_scale", 1.0)) == FURTHER_NAME_LN
    assert reach(ranked("camera_perspective", 1.0)) == NEIGHBOUR_EVIDENCE_LN


@pytest.mark.parametrize(
    ("rival", "behind", "is_one"),
    [("camera_scale", 2.0, True), ("camera_scale", 7.0, False), ("stiffness_drift", 2.0, False)],
)
def test_what_acts_at_another_place_is_a_rival_where_it_explains_about_as_much(
    rival: str, behind: float, is_one: bool
):
    named = SimpleNamespace(effect=effect("arc_error"), ln_bayes_factor=13.0)
    assert explains_as_much(ranked(rival, 13.0 - behind), named) is is_one


@pytest.mark.parametrize(("in_own_words", "rivals"), [(115.0, {"force_offset"}), (101.0, set())])
def test_what_explains_more_in_its_own_words_is_a_rival_though_it_imitates_no_name(
    monkeypatch, in_own_words: float, rivals: set[str]
):
    words = {"surface_tension": 100.0, "force_offset": in_own_words}
    monkeypatch.setattr(neighbours, "evidence", lambda *_: words)
    monkeypatch.setattr(neighbours, "_imitates", lambda *_: False)
    ranking = [ranked("surface_tension", 26.7), ranked("force_offset", 20.6)]
    one = SimpleNamespace(
        effect=effect("surface_tension"), ln_bayes_factor=26.7, before=None, ranking=ranking
    )
    assert set(neighbours._odds(SimpleNamespace(log_sigma=None), one)) == rivals


def test_of_names_that_may_be_meant_the_likeliest_comes_first():
    judged = Judged({"a": 0.6, "b": 0.1, "c": 0.25}, ("a", "b", "c"))
    decision = SimpleNamespace(
        choice_sets=(ChoiceSet("a", ()),), answers=(judged,), criticism=Criticism(), named=[],
        nonparametric_explains_more=False, unknown=None, known=SimpleNamespace(found=()),
    )  # fmt: skip
    assert of_name("a", decision).confusable_with == ("c", "b")
