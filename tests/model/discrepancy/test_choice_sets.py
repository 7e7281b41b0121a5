"""The answers that compete for each place of a verdict, with what the search knows of them."""

from __future__ import annotations

import json

import pytest

from benchmarks.hidden_effects.cases import Case, Hiding
from model.discrepancy.answers.choice_set import ATTRIBUTES, NOTHING, UNKNOWN, ChoiceSet
from tests.model.discrepancy.sessions import FALLING, diagnosed

TWO = Case((Hiding("nonuniform_eibm"), Hiding("clamp_angle")), seed=2)


def attributes(one: ChoiceSet, name: str):
    return next(a.attributes for a in one.alternatives if a.name == name)


@pytest.mark.slow
def test_nothing_named_leaves_one_question():
    (only,) = diagnosed().choice_sets
    assert only.considered == NOTHING
    assert attributes(only, NOTHING)["nothing_considered"] == 1.0
    assert attributes(only, NOTHING)["nothing_further"] == 0.0
    names = [a.name for a in only.alternatives]
    assert names[-2:] == [UNKNOWN, NOTHING]
    assert len(names) == len(set(names)) > 4


@pytest.mark.thorough
@pytest.mark.slow
def test_each_name_has_its_question_and_there_is_one_about_the_rest():
    first, rest = diagnosed(FALLING).choice_sets
    assert (first.considered, rest.considered) == ("nonuniform_eibm", NOTHING)
    own = attributes(first, "nonuniform_eibm")
    assert own["behind"] == 0.0
    assert own["considered"] == own["first"] == own["votes"] == 1.0
    assert own["failed"] == 0.0
    assert own["uneven"] < 0.5
    assert own["misfit"] < 0.5
    others = [a for a in first.alternatives if a.name not in ("nonuniform_eibm", UNKNOWN, NOTHING)]
    assert all(a.attributes["behind"] > 0.0 and "considered" not in a.attributes for a in others)
    assert attributes(first, UNKNOWN)["unknown_ahead"] < 0.0
    assert attributes(rest, NOTHING)["nothing_further"] == 1.0
    assert "nonuniform_eibm" not in [a.name for a in rest.alternatives]


@pytest.mark.thorough
def test_a_second_name_is_voted_for_beside_the_first():
    """Without the first in place no position would choose it: the first explains more alone."""
    found = {one.considered: one for one in diagnosed(TWO).choice_sets}
    for name in ("nonuniform_eibm", "clamp_angle"):
        own = attributes(found[name], name)
        assert own["votes"] == 1.0


@pytest.mark.slow
def test_every_attribute_is_documented_and_of_the_order_of_one():
    for one in (*diagnosed().choice_sets, *diagnosed(FALLING).choice_sets):
        for alternative in one.alternatives:
            assert set(alternative.attributes) <= set(ATTRIBUTES)
            assert all(abs(v) < 12.0 for v in alternative.attributes.values())


@pytest.mark.slow
def test_a_choice_set_survives_a_record():
    for one in diagnosed(FALLING).choice_sets:
        again = ChoiceSet.from_json(json.loads(json.dumps(one.to_json())))
        assert again.considered == one.considered
        for kept, made in zip(again.alternatives, one.alternatives, strict=True):
            assert kept.name == made.name
            assert kept.attributes == pytest.approx(made.attributes, abs=1e-4)
