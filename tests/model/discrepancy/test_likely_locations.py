"""Where something unknown acts: what each location can say, and how likely each one is."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy import diagnose
from model.discrepancy.thresholds import EVIDENCE_TEMPERATURE, LOCATION_FORM_SHARE
from model.discrepancy.verdict.likely_locations import likely_locations
from model.discrepancy.verdict.messages import located, sentence
from model.discrepancy.verdict.result import BeforeAfter, Gap, Unknown
from model.locations.basis import odd_functions
from tests.model.discrepancy.foreign_sessions import Foreign, foreign_session


def free(where: str, gain: float) -> SimpleNamespace:
    candidate = SimpleNamespace(location=where)
    return SimpleNamespace(
        name=f"unknown:{where}", ln_bayes_factor=gain, score=SimpleNamespace(candidate=candidate)
    )


def effect(name: str, where: str, gain: float) -> SimpleNamespace:
    return SimpleNamespace(**{**vars(free(where, gain)), "name": name})


def test_locations_that_explain_as_much_are_as_likely():
    found = likely_locations(free("load_cell", 20.0), [free("position", 20.0), free("eibm", -1.0)])
    assert list(found) == ["load_cell", "position"]
    assert list(found.values()) == pytest.approx([0.5, 0.5], abs=1e-4)


def test_a_location_that_explains_much_less_is_not_told():
    assert list(likely_locations(free("camera", 20.0), [free("eibm", 10.0)])) == ["camera"]


def test_of_a_strong_form_the_basis_of_the_right_location_may_miss_a_share():
    found = likely_locations(free("eibm", 400.0), [free("compliance", 376.0)])
    width = LOCATION_FORM_SHARE * 400.0
    assert width > EVIDENCE_TEMPERATURE
    assert list(found) == ["eibm", "compliance"]
    assert found["compliance"] == pytest.approx(1.0 / (1.0 + np.exp(24.0 / width)))


def test_the_reported_location_is_first_and_no_name_is_one():
    """What hides in the noise of pictures may explain less by itself than another location."""
    ranking = [effect("gravity", "even_moment", 90.0), free("time", 30.0), free("camera", 1.0)]
    found = likely_locations(free("camera", 25.0), ranking)
    assert set(found) == {"camera", "time"}
    assert found["time"] <= found["camera"]
    assert next(iter(found)) == "camera"


PLAIN = Unknown(
    location="load_cell", configuration="long", s_mm=np.array([0.0, 10.0]),
    profile=np.array([0.0, 1.0]), band=np.zeros(2), unit="mN", along="position",
    depends="in the force alone",
)  # fmt: skip


def test_the_sentence_has_all_locations_with_their_shares():
    gap = Gap(**dict.fromkeys(Gap.__dataclass_fields__, float("nan")))
    one = replace(PLAIN, locations={"load_cell": 0.68, "position": 0.22, "even_moment": 0.1})
    said = sentence("unknown_effect", [], one, BeforeAfter(gap, gap), "")
    assert "Location: load cell, 68 % (in the force alone); largest at 10 mm." in said
    assert "It may act elsewhere: position, 22 % or even moment, 10 %." in said
    assert one.to_json()["slots"] == {"load_cell": 0.68, "position": 0.22, "even_moment": 0.1}


def test_a_single_location_has_no_share():
    assert located(replace(PLAIN, locations={"load_cell": 1.0})) == "load cell"
    assert located(PLAIN) == "load cell"


def test_what_is_odd_is_odd_about_the_middle():
    t = np.linspace(0.0, 1.0, 11)
    for function in odd_functions(0.3):
        np.testing.assert_allclose(function(t), -function(1.0 - t), atol=1e-15)
        assert np.max(function(t)) == pytest.approx(0.3, rel=1e-3)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("hidden", "says"),
    [
        (
            Foreign(stiffness=lambda bent, volts, s: 1.0 + 0.25 * (volts > 0.0) + 0.0 * bent),
            "of its own at each polarity",
        ),
        (
            Foreign(stiffness=lambda bent, volts, s: 1.0 + 0.06 * np.tanh(bent / 6.0)),
            "which way",
        ),
    ],
    ids=["by polarity", "by the way it is bent"],
)
def test_a_sheet_that_is_stiffer_on_one_side_is_told_to_be_so(hidden, says):
    found = diagnose(foreign_session(hidden, 5))
    assert found.unknown is not None
    assert found.unknown.location == next(iter(found.unknown.locations)) == "compliance"
    assert says in found.unknown.depends
