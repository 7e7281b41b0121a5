"""Names of one location are compared in wordings that the catalogue does not have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.discrepancy.answers.calibrated_answers import Judged
from model.discrepancy.answers.reported_set import shared
from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.criticise import Criticism
from model.discrepancy.criticism.wordings import evidence, without_contact, wordings
from model.discrepancy.search.evidence import candidates
from model.discrepancy.verdict.probable_names import of_others
from model.effects import effect
from tests.model.discrepancy.sessions import Case, Extras, base_fit

WITH_ZEROS = Case((), extras=Extras(no_touch_zero=True), seed=3)
TOUCHING = "the force of the sheet, and its zero without contact"


@pytest.fixture(scope="module")
def bare():
    return base_fit(WITH_ZEROS)


def pulled(fitted, *, everywhere: bool):
    """Return a fit whose forces are 0.1 mN too high, in contact alone or everywhere."""
    (one,) = candidates(fitted, [effect("force_offset")])
    row = 2.0 * one.columns[:, 0]
    if not everywhere:
        row = np.where(without_contact(fitted.problem.forward), 0.0, row)
    data = fitted.linear.data
    row_index = fitted.problem.forward.row_index
    linear = replace(fitted.linear, data=replace(data, y=data.y + row_index.pad(row)))
    return replace(fitted, linear=linear)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_zero_in_contact_alone_is_as_good_a_zero_as_a_meniscus_is(bare):
    both = [effect("force_offset"), effect("surface_tension")]
    fitted = pulled(bare, everywhere=False)
    found = evidence(fitted, fitted.solution.log_sigma, both)
    assert abs(found["force_offset"] - found["surface_tension"]) < 6.0


@pytest.mark.slow
def test_a_zero_in_readings_without_contact_is_no_meniscus(bare):
    both = [effect("force_offset"), effect("surface_tension")]
    fitted = pulled(bare, everywhere=True)
    found = evidence(fitted, fitted.solution.log_sigma, both)
    assert found["force_offset"] > found["surface_tension"] + 6.0


@pytest.mark.slow
def test_the_wording_without_deviations_keeps_the_size_of_each_sheet(bare):
    stated, exact, equal = wordings(bare, effect("surface_tension"))
    assert exact[0].columns.shape[1] == 2 < stated[0].columns.shape[1]
    assert np.array_equal(exact[0].columns, stated[0].columns[:, :2])
    assert np.array_equal(equal[0].columns, stated[0].columns[:, :1])


def test_names_that_nothing_tells_apart_have_their_probability_together():
    chances = shared({"a": 0.9, "b": 0.02, "unknown": 0.05}, {"a": 1.0, "b": 0.5})
    assert chances["a"] == pytest.approx(0.92 / 1.5)
    assert chances["b"] == pytest.approx(0.46 / 1.5)
    assert chances["unknown"] == 0.05


def test_odds_are_those_of_the_name_s_own_rivals():
    alike = {"sentence": "", "consequence": Consequence.INDISTINGUISHABLE}
    failures = (
        Failure(**alike, effects=("a",), rivals=("b", "c"), odds=(0.5, 0.1)),
        Failure(**alike, effects=("d",), rivals=("e",), odds=(1.0,)),
    )
    assert Criticism(failures=failures).odds("a") == {"b": 0.5, "c": 0.1}


def test_a_second_name_of_a_location_counts_with_the_others_that_it_may_be():
    judged = Judged({"b": 0.6, "c": 0.2, "a": 0.1, "unknown": 0.06, "nothing": 0.04}, ("b",))
    assert of_others(judged, {"a"}) == pytest.approx(0.8)


def test_a_rival_that_is_likelier_in_other_words_takes_the_place_of_a_name():
    alike = {"consequence": Consequence.INDISTINGUISHABLE, "sentence": "alike", "effects": ("a",)}
    found = Criticism(failures=(Failure(**alike, rivals=("b", "c"), odds=(3.0, 0.1)),))
    assert found.likelier("a") == "b"
    assert found.likelier("d") == ""
    assert found.odds("a") == {"b": 1.0, "c": 0.1}  # what is reported has no less than the others
    less = Criticism(failures=(Failure(**alike, rivals=("b",), odds=(1.0,)),))
    assert less.likelier("a") == ""
