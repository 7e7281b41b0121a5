"""Probabilities of the answers to a question, and the set that is reported."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from model.discrepancy.answers.calibrated_answers import (
    REPORTED,
    SOMETHING,
    CalibratedAnswers,
    calibrated,
)
from model.discrepancy.answers.choice_set import (
    ATTRIBUTES,
    NOTHING,
    UNKNOWN,
    Alternative,
    ChoiceSet,
)
from model.discrepancy.thresholds import LEAST_CONTENT_OF_UNKNOWN

ASKED = ChoiceSet(
    "gravity",
    (
        Alternative("gravity", {"first": 1.0}),
        Alternative("clamp_angle", {"behind": 2.0}),
        Alternative(UNKNOWN, {"unknown": 1.0}),
        Alternative(NOTHING, {"nothing": 1.0}),
    ),
)
WEIGHTS = {"first": 1.0, "behind": -1.0, "unknown": -0.5, "nothing": -4.0}


def test_probabilities_are_those_of_a_conditional_logit():
    found = CalibratedAnswers(WEIGHTS, dict.fromkeys(REPORTED, 0.95)).probabilities(ASKED)
    total = sum(math.exp(u) for u in (1.0, -2.0, -0.5, -4.0))
    assert found == pytest.approx({
        "gravity": math.exp(1.0) / total, UNKNOWN: math.exp(-0.5) / total,
        "clamp_angle": math.exp(-2.0) / total, NOTHING: math.exp(-4.0) / total,
    })  # fmt: skip
    assert list(found) == ["gravity", UNKNOWN, "clamp_angle", NOTHING]


@pytest.mark.parametrize(
    ("considered", "answers"),
    [
        ("gravity", ("gravity", UNKNOWN)),
        (UNKNOWN, ("gravity", UNKNOWN)),
        (NOTHING, ("gravity", UNKNOWN, "clamp_angle", NOTHING)),
    ],
)
def test_a_set_has_the_likeliest_answers_up_to_the_content_of_what_is_said(considered, answers):
    own = CalibratedAnswers(WEIGHTS, {SOMETHING: 0.9, NOTHING: 1.0})
    judged = own.judged(replace(ASKED, considered=considered))
    assert judged.answers == answers
    assert judged.likeliest == "gravity"
    chances = judged.probabilities
    assert judged.of_names == chances["gravity"] + chances["clamp_angle"]


@pytest.mark.parametrize(("considered", "size"), [("gravity", 1), (UNKNOWN, 2), (NOTHING, 1)])
def test_the_set_of_something_unknown_has_a_name_that_it_may_be_in_another_form(considered, size):
    own = CalibratedAnswers(
        {"unknown": 2.0, "behind": -1.0, "nothing": -9.0}, dict.fromkeys(REPORTED, 0.8)
    )
    asked = replace(ASKED, considered=considered)
    chances = own.probabilities(asked)
    assert 0.8 < chances[UNKNOWN] < LEAST_CONTENT_OF_UNKNOWN
    assert len(own.judged(asked).answers) == size


def test_large_utilities_do_not_overflow():
    weights = {"first": 2000.0}
    found = CalibratedAnswers(weights, dict.fromkeys(REPORTED, 0.95)).probabilities(ASKED)
    assert found["gravity"] == 1.0


def test_the_file_that_is_shipped_has_a_number_for_every_attribute_and_kind():
    used = calibrated()
    assert set(used.weights) == set(ATTRIBUTES)
    assert set(used.contents) == set(REPORTED)
    assert all(0.8 <= content < 1.0 for content in used.contents.values())
    assert used.weights["behind"] <= 0.0
