"""What differs between sessions that are analysed together is named, and predicted for each."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from benchmarks.hidden_effects.several_days import measured
from model import Measurements, predict
from model.discrepancy import Diagnosis, diagnose
from tests.fits_unchecked import fits_unchecked
from tests.model.discrepancy.sessions import means_of

ZEROS_MN = (-0.2, 0.3)


@cache
def two_days(zeros_mN: tuple[float, ...] = ZEROS_MN) -> Measurements:
    """The long sheet on two days, between which the load cell was tared anew."""
    whole = means_of(measured("session_zero", zeros_mN, seed=7))
    long = tuple(c for c in whole.conditions if c.configuration == "long")
    return replace(whole, sheets={"long": whole.sheets["long"]}, conditions=long)


@cache
def found() -> Diagnosis:
    with fits_unchecked():
        return diagnose(two_days())


@pytest.mark.thorough
@pytest.mark.slow
def test_a_zero_that_another_day_has_is_said_to_differ_between_sessions():
    assert [one.name for one in found().effects] == ["session_zero"]
    parameters = found().effects[0].parameters
    for zero, (name, told) in zip(ZEROS_MN, parameters.items(), strict=True):
        low, high = told.interval(0.999)
        assert low < zero < high, name
    assert "session 1 -0.2" in found().sentence
    assert "session 2 +0.3" in found().sentence
    assert set(found().to_json()["effects"][0]["parameters"]) == {"session_1_mN", "session_2_mN"}


@pytest.mark.slow
def test_the_written_model_predicts_each_session():
    model = found().model
    assert model.sessions == 2
    by_session = [predict(model.in_session(number), "long", 0.015, 0.0).F_N for number in (0, 1, 2)]
    mean, first, second = by_session
    assert second - first == pytest.approx(0.5e-3, abs=0.05e-3)
    assert mean == pytest.approx(0.5 * (first + second))
    # each session's own errors are those that the file states
    assert model.merit["force_rmse_N"] < 0.06e-3


@pytest.mark.thorough
def test_a_zero_that_is_the_same_on_both_days_is_an_offset():
    names = [one.name for one in diagnose(two_days((0.3, 0.3))).effects]
    assert names == ["force_offset"]
