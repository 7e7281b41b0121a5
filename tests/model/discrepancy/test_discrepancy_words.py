"""The verdict as a sentence, also where there is nothing to be said of a kind."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model import Parameter
from model.discrepancy.answers.calibrated_answers import Judged
from model.discrepancy.search.nonparametric_terms import shapes
from model.discrepancy.verdict.inferred_form import dependence, under_applied_voltages
from model.discrepancy.verdict.messages import (
    improbable,
    open_answers,
    promise_note,
    sentence,
    too_few,
    worse,
)
from model.discrepancy.verdict.result import (
    BeforeAfter,
    ClosedGap,
    Gap,
    Named,
    Next,
    Promise,
    Unknown,
)
from tests.model.discrepancy.sessions import base_fit

NAN = float("nan")
NAMED = Named(
    name="gravity", location="even_moment", parameters={}, by_configuration={}, confidence=1.0,
    confusable_with=(), form_share=0.0,
)  # fmt: skip


def gap(force_mN: float, curve_mm: float, chi2: float, **further: float) -> Gap:
    return Gap(force_rmse_mN=force_mN, curve_rmse_mm=curve_mm, chi2_per_dof=chi2, **further)


@pytest.mark.parametrize(
    ("before", "after", "wanted"),
    [
        (gap(0.2, 1.5, 9.0), gap(0.03, 0.04, 1.0),
         "force 0.200 → 0.030 mN, neutral curve 1.500 → 0.040 mm."),
        (gap(0.2, NAN, 9.0), gap(0.03, NAN, 1.0), "force 0.200 → 0.030 mN."),
        (gap(NAN, 1.5, 9.0), gap(NAN, 0.04, 1.0), "neutral curve 1.500 → 0.040 mm."),
        (gap(NAN, NAN, NAN), gap(NAN, NAN, NAN), "the prediction error is not known."),
        # fine shapes are little in mm, where coarse ones scatter
        (gap(0.026, 0.045, 15.3), gap(0.026, 0.044, 1.08),
         "force 0.026 → 0.026 mN, neutral curve 0.045 → 0.044 mm, 3.91 → 1.04 times the noise."),
    ],
)  # fmt: skip
def test_what_was_not_measured_is_not_in_the_sentence(before, after, wanted):
    said = sentence("effect_named", [NAMED], None, BeforeAfter(before, after), 14)
    assert said.startswith("Gravity is not in the model. ")
    assert said.endswith(wanted)
    assert "nan" not in said


def test_what_is_predicted_worse_than_before_is_told():
    noise, both = gap(0.01, 0.005, 1.0), BeforeAfter(gap(0.025, 0.552, 9.0), gap(0.677, 0.344, 1.0))
    told = list(worse(both, noise))
    assert len(told) == 1
    assert told[0].startswith("the force at left-out positions is predicted worse than")
    within_noise = BeforeAfter(gap(0.005, NAN, 1.0), gap(0.011, NAN, 1.0))
    assert not list(worse(within_noise, noise))


def test_effects_bear_the_names_that_readers_know():
    both = BeforeAfter(gap(0.2, 1.5, 9.0), gap(0.03, 0.04, 1.0))
    named = [replace(NAMED, name=name) for name in ("nonuniform_eibm", "charging_lag")]
    said = sentence("effect_named", named, None, both, "")
    assert said.startswith("EIBM along the sheet and charging lag are not in the model. ")


def test_what_differs_between_sessions_is_told_for_each():
    both = BeforeAfter(gap(0.2, 1.5, 9.0), gap(0.03, 0.04, 1.0))
    zeros = {
        f"session_{number}_mN": Parameter(value=value, sigma=0.01, unit="mN")
        for number, value in ((1, -0.2), (2, 0.3))
    }
    stiffer = {"session_2": Parameter(value=0.2, sigma=0.01, unit="")}
    named = [
        replace(NAMED, name="session_zero", parameters=zeros),
        replace(NAMED, name="session_stiffness", parameters=stiffer),
    ]
    said = sentence("effect_named", named, None, both, "")
    assert "session 1 -0.2 mN (-0.216 to -0.184), session 2 +0.3 mN (+0.284 to +0.316). " in said
    assert "session: session 2 less session 1 +20 % (+18.4 to +21.6). Prediction" in said


def test_several_are_listed_with_the_change_of_each_error():
    before, after = (
        gap(0.2, 1.5, 9.0, drift_rmse_mN=0.02, pulse_rmse_mN=0.114, drift_rmse_mm=0.013),
        gap(0.03, 0.04, 1.0, drift_rmse_mN=0.02, pulse_rmse_mN=0.008, drift_rmse_mm=0.0004),
    )
    both = BeforeAfter(before, after)
    said = sentence("effect_named", [NAMED, NAMED, NAMED], None, both, "")
    assert said == (
        "Gravity, gravity and gravity are not in the model. Prediction error on left-out positions"
        " (RMS), before → after: force 0.200 → 0.030 mN, neutral curve 1.500 → 0.040 mm, neutral"
        " curve along a run 0.0130 → 0.0004 mm, force within a pulse 0.114 → 0.008 mN."
    )


def test_a_class_is_named_with_all_its_members_and_their_common_probability():
    both = BeforeAfter(gap(0.2, 1.5, 9.0), gap(0.03, 0.04, 1.0))
    one = replace(NAMED, confusable_with=("clamp_angle",), confidence=0.93)
    said = sentence("indistinguishable", [one], None, both, "")
    assert said.startswith(
        "Gravity or clamp angle (which these data cannot tell apart; together 93 %) is not in the"
        " model. "
    )


def test_a_name_that_may_be_something_unknown_says_so():
    both = BeforeAfter(gap(0.2, 1.5, 9.0), gap(0.03, 0.04, 1.0))
    one = replace(NAMED, or_else=("unknown",), confidence=0.8)
    said = sentence("indistinguishable", [one], None, both, "")
    assert said.startswith(
        "Gravity or something that is not in the catalogue (80 % that it is gravity) is not in the"
        " model. "
    )
    one = replace(one, confusable_with=("clamp_angle",))
    said = sentence("indistinguishable", [one], None, both, "")
    assert said.startswith(
        "Gravity or clamp angle or something that is not in the catalogue (which these data cannot"
        " tell apart; the names together 80 %) is not in the model. "
    )


def test_an_unknown_that_a_name_may_be_all_the_same_says_so():
    curve = np.zeros(2)
    one = Unknown(
        location="eibm", configuration="long", s_mm=curve, profile=curve, band=curve, unit="",
        along="s", depends="under voltage", confusable_with=("gravity", "clamp_angle"),
    )  # fmt: skip
    both = BeforeAfter(gap(0.2, 0.05, 9.0), gap(0.03, 0.05, 1.0))
    said = sentence("unknown_effect", [], one, both, "")
    assert said == (
        "Something is not in the model; it may be gravity or clamp angle, or something that is not"
        " in the catalogue. Location: EIBM (under voltage); largest at 0 mm. Prediction error"
        " on left-out positions (RMS), before → after: force 0.200 → 0.030 mN, neutral curve 0.050"
        " → 0.050 mm."
    )
    single = replace(one, confusable_with=("first_pulse_transient",))
    assert sentence("unknown_effect", [NAMED], single, both, "").startswith(
        "Something besides gravity is not in the model; it may be first pulse transient, or"
        " something that is not in the catalogue. Location: "
    )


def test_an_unknown_whose_curve_predicts_nothing_between_the_positions_says_so():
    curve = np.zeros(2)
    one = Unknown(
        location="load_cell", configuration="long", s_mm=curve, profile=curve, band=curve, unit="",
        along="force", depends="in the force alone",
    )  # fmt: skip
    same = BeforeAfter(gap(0.165, 0.03, 5.0), gap(0.171, 0.03, 5.0))
    closed = ClosedGap(
        share=-0.1, quantity="force", before=0.165, after=0.171, floor=0.065, unit="mN"
    )
    said = sentence("unknown_effect", [], one, same, "", closed)
    assert said.endswith("The curve does not improve the prediction between the positions.")


def test_what_is_not_likely_enough_is_told_with_the_other_answers():
    judged = Judged({"unknown": 0.7, "gravity": 0.25}, ("unknown", "gravity"))
    assert improbable("gravity", judged) == (
        "gravity explains most, but with a probability of only 25 %; it may be something that is"
        " not in the catalogue or gravity"
    )
    assert improbable("nothing", judged) == (
        "little speaks for anything, but it may be something that is not in the catalogue or"
        " gravity"
    )


@pytest.mark.parametrize(("besides", "begins"), [(False, ""), (True, " besides")])
def test_what_is_not_ruled_out_is_told_beside_nothing_and_beside_what_is_reported(besides, begins):
    told = [*open_answers({"gravity": 0.1}, besides=besides)]
    assert told == [f"not ruled out{begins}: gravity (10 %)"]
    assert [*open_answers({}, besides=besides)] == []


def test_a_closed_share_is_said_with_its_errors_and_the_floor():
    both = BeforeAfter(gap(0.023, 1.5, 9.0), gap(0.024, 0.04, 1.0))
    curves = ClosedGap(
        share=0.999, quantity="neutral curve", before=1.5, after=0.04, floor=0.02, unit="mm"
    )
    said = sentence("effect_named", [NAMED], None, both, "", curves)
    assert said.endswith(
        " Gap closed above the noise floor: more than 99 % of neutral curve"
        " (1.500 → 0.040 mm, floor 0.020)."
    )


def test_what_was_promised_of_a_measurement_is_said_with_what_was_found():
    proposal = Next(
        why="", extra="free_shapes", separation=1.8, expected=6.0, minutes=2.0, protocol={},
        between=("gravity", "clamp_angle"),
    )  # fmt: skip
    assert promise_note(Promise(proposal, 4.8)) == (
        "measured as proposed (free shapes): gravity and clamp angle were 1.8 sigma apart;"
        " promised 6.0, found 4.8"
    )


def test_what_acts_only_under_voltage_is_not_said_to_act_at_all_voltages():
    assert dependence("compliance", "curvature", "curvature", "voltage") == (
        "in proportion to the moment, by how far the sheet is bent, only under voltage"
    )


@pytest.mark.parametrize(
    ("location", "part", "what"),
    [
        ("time", "curvature, session", "the initial curvature in the course of the session"),
        ("time", "stiffness, run", "the stiffness in the course of each run"),
        ("load_cell", "gain, session", "the gain in the course of the session"),
        ("position", "position, run", "the position in the course of each run"),
        ("camera", "place, session", "the whole picture in the course of the session"),
        ("camera", "scale, session", "the scale of the picture in the course of the session"),
    ],
)
def test_what_changes_in_time_is_said(location: str, part: str, what: str):
    assert dependence(location, part, "time", "").endswith(f", {what}")


def test_it_is_said_when_a_camera_was_knocked():
    """At the 14th of 20 times between the session's ends."""
    shows = shapes(base_fit(), "camera", "knock 14, session")[0].shows
    assert dependence("camera", "knock 14, session", "time", "", shows).endswith(
        "; about 67 % into the session the whole picture moves at once"
    )


@pytest.mark.parametrize(
    ("volts", "told"), [((0.0, 2.0, -2.0), "polarity"), ((0.0, 2.0), "voltage")]
)
def test_of_one_polarity_alone_nothing_is_said_of_the_other(volts, told):
    parts = [SimpleNamespace(voltage_V=np.array(volts))]
    fitted = SimpleNamespace(
        problem=SimpleNamespace(forward=SimpleNamespace(configuration_models=parts))
    )
    assert under_applied_voltages(fitted, "polarity") == told


@pytest.mark.parametrize(
    ("setups", "wanted"),
    [(0, "there is no set-up of"), (1, "there is one set-up of"), (3, "there are 3 set-ups of")],
)
def test_the_number_of_set_ups_is_said_in_english(setups, wanted):
    assert too_few(setups).startswith(wanted)
