"""The result of a session as plain data: what was measured, what models say, how it settles."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.band_coverage import tally
from labrig.analysis.results import converging, reading_curve, result_of
from labrig.analysis.results.models import models_of
from labrig.analysis.results.predicted import predicted_by
from labrig.errors import BadInputError
from model import Along, fit, predict
from model.parameter import Parameter
from model.sheet.beam_problem import ActiveEffect
from sim_hardware.world import load_world
from tests.labrig.report_data import measure

pytestmark = pytest.mark.slow  # fits


@pytest.fixture(scope="module")
def measured():
    return measure()


@pytest.fixture(scope="module")
def fitted(measured):
    return fit(measured)


@pytest.fixture(scope="module")
def result(measured, fitted):
    return result_of(measured, session="a.h5", fitted=fitted)


def conditions(result):
    return [one for part in result["configurations"] for one in part["conditions"]]


def test_the_result_is_json_without_numbers_that_json_does_not_know(result):
    assert json.loads(json.dumps(result, allow_nan=False)) == result
    assert (result["session"], result["format"]) == ("a.h5", 1)


def test_means_and_standard_errors_are_those_of_the_readings(result, measured):
    for one in conditions(result):
        readings = [1e3 * r.force_N for r in measured.conditions[one["id"]].used()]
        assert one["force"]["mean_mN"] == pytest.approx(np.mean(readings))
        error = np.std(readings, ddof=1) / np.sqrt(len(readings))
        assert one["force"]["sigma_mN"] == pytest.approx(error)


def test_points_of_a_measured_curve_are_points_of_the_file(result, measured):
    for one in conditions(result):
        curve = measured.conditions[one["id"]].curve
        shown = np.column_stack([one["curve"]["x_mm"], one["curve"]["y_mm"]])
        there = 1e3 * np.column_stack([curve.x_m, curve.y_m])
        away = [np.min(np.hypot(*(there - point).T)) for point in shown]
        assert max(away) < 1e-4
        assert np.allclose(shown[[0, -1]], there[[0, -1]], atol=1e-4)


def test_a_model_s_force_and_shape_are_those_it_predicts(result, fitted):
    for part in result["configurations"]:
        one = part["conditions"][-1]
        for key, model in (("constant", fitted.model), ("along", fitted.varying_model)):
            wanted = predict(model, part["name"], 1e-3 * one["position_mm"], one["voltage_V"])
            shown = one["models"][key]
            assert shown["force_mN"] == pytest.approx(1e3 * wanted.F_N)
            assert np.allclose(shown["curve"]["x_mm"], 1e3 * wanted.x_m, atol=1e-4)
            assert np.allclose(shown["curve"]["y_mm"], 1e3 * wanted.y_m, atol=1e-4)


def test_the_parameters_part_of_a_band_is_that_of_repeated_draws(result, measured, fitted):
    """B and EIBM are drawn with their correlation, as the fit states it."""
    joint, random = fitted.joint, np.random.default_rng(1)
    n = joint.forward.names.index("long")
    rows = joint.directions(n)
    D = np.array([rows["B"], rows["EIBM at +2 V"]])
    draws = random.multivariate_normal(np.zeros(2), D @ joint.fitted.covariance @ D.T, size=200)
    sheet = fitted.model.sheets["long"]
    one = next(
        one for one in conditions(result) if one["voltage_V"] == 2.0 and one["position_mm"] == 10.0
    )
    forces = []
    for dB, dM in draws:
        along = sheet.eibm[2.0]
        moved = replace(
            sheet,
            B=replace(sheet.B, value=sheet.B.value + dB),
            eibm={**sheet.eibm, 2.0: replace(along, values=along.values + dM)},
        )
        model = replace(fitted.model, sheets={"long": moved})
        forces.append(1e3 * predict(model, "long", 10e-3, 2.0).F_N)
    constant = models_of(fitted, None)[0]
    own = {name: found[:-1] for name, found in constant.displaced.items()}  # not that along s
    alone = predicted_by(replace(constant, displaced=own, scatter={}), measured)
    low, high = alone.conditions[one["id"]]["force90_mN"]
    assert high < one["models"]["constant"]["force90_mN"][1]  # which holds measurements
    # the stated sigma also holds the doubt about k0, and Student's t for few degrees of freedom
    assert 1.0 < 0.5 * (high - low) / (1.645 * np.std(forces)) < 1.6


def test_lines_go_through_the_predicted_forces_with_their_bands(result):
    for part in result["configurations"]:
        by = {(one["position_mm"], one["voltage_V"]): one for one in part["conditions"]}
        assert len(part["lines"]) == 2 * len(part["voltages_V"])
        for line in part["lines"]:
            for position in part["positions_mm"]:
                at = line["p_mm"].index(position)
                one = by[position, line["voltage_V"]]["models"][line["model"]]
                assert line["F_mN"][at] == pytest.approx(one["force_mN"], abs=1e-3)
                half = 0.5 * (one["force90_mN"][1] - one["force90_mN"][0])
                assert line["half90_mN"][at] == pytest.approx(half, abs=1e-3)


@pytest.mark.thorough
def test_the_last_step_of_the_convergence_is_the_fit_of_all(measured, fitted):
    points = converging(measured, whole=fitted)
    last = list(measured.sheets)[-1]
    one = fitted.configurations[last]
    assert points[last][-1]["B_uNm2"]["value"] == pytest.approx(1e6 * one.B.value)
    low, high = one.eibm[2.0].interval()
    assert points[last][-1]["EIBM_uNm"]["2.0"]["interval90"] == pytest.approx(
        [1e6 * low, 1e6 * high]
    )
    for name, steps in points.items():
        assert [step["positions"] for step in steps] == list(range(1, len(steps) + 1))
        known = [s["B_uNm2"]["interval90"] for s in steps if s["B_uNm2"]]
        assert np.ptp(known[-1]) < np.ptp(known[0]), name


@pytest.mark.thorough
def test_a_fit_that_begins_where_an_earlier_one_ended_finds_the_same(measured, fitted):
    points = converging(measured)  # each fit but the first begins so
    last = list(measured.sheets)[-1]
    found, B = points[last][-1]["B_uNm2"], fitted.configurations[last].B
    assert abs(found["value"] - 1e6 * B.value) < 0.05e6 * B.sigma
    assert found["sigma"] == pytest.approx(1e6 * B.sigma, rel=0.05)


@pytest.mark.thorough
def test_steps_that_are_known_are_not_fitted_again(measured):
    last = list(measured.sheets)[-1]
    points = converging(measured)
    points[last][0]["why"] = "kept"
    again = converging(measured, points)
    assert again == points
    asked = iter([False, True])
    assert sum(map(len, converging(measured, cancelled=lambda: next(asked)).values())) == 1


@pytest.mark.thorough
def test_steps_without_enough_data_say_why(measured):
    curves = tuple(replace(c, readings=c.readings[:0]) for c in measured.conditions)
    nothing = converging(replace(measured, conditions=curves))
    rest = converging(replace(measured, conditions=measured.conditions[::3]))  # 0 V alone
    for name, steps in nothing.items():
        assert all(step["B_uNm2"] is None and name in step["why"] for step in steps)
        assert rest[name][-1]["B_uNm2"]
        assert rest[name][-1]["EIBM_uNm"] == {}


def test_forces_alone_and_curves_alone_make_a_result(measured):
    forces = replace(
        measured, conditions=tuple(replace(c, curve=None) for c in measured.conditions)
    )
    assert all(one["curve"] is None and one["force"] for one in conditions(result_of(forces)))
    curves = replace(
        measured, conditions=tuple(replace(c, readings=()) for c in measured.conditions)
    )
    shown = conditions(result_of(curves))
    assert all(one["force"] is None and one["curve"] and not one["models"] for one in shown)


@pytest.mark.thorough
def test_effects_widen_the_band_by_the_doubt_about_their_parameters(measured, fitted):
    def amount(sigma):
        return ActiveEffect(
            name="force_offset",
            parameters={"force_mN": Parameter(value=0.2, sigma=sigma, unit="mN")},
        )

    def halves(model):
        shown = conditions(result_of(measured, fitted=fitted, with_effects=model))
        return np.array([np.ptp(one["models"]["effects"]["force90_mN"]) / 2 for one in shown])

    sure = halves(fitted.model.with_effects(amount(0.0)))
    unsure = halves(fitted.model.with_effects(amount(0.1)))
    freedom = fitted.model.sheets["long"].B.freedom
    reach = Parameter(value=0.0, sigma=0.1, unit="mN", freedom=freedom).interval()[1]
    assert np.allclose(np.sqrt(unsure**2 - sure**2)[:3], reach, rtol=1e-3)


def test_the_curve_of_one_reading_is_given_when_asked_for(measured):
    first = measured.conditions[0]
    curve = first.curve
    with_one = replace(first, readings=(replace(first.readings[0], curve=curve),))
    session = replace(measured, conditions=(with_one, *measured.conditions[1:]))
    assert conditions(result_of(session))[0]["readings"][0]["curve"]
    shown = reading_curve(session, 0, first.readings[0].index)
    assert shown["x_mm"][-1] == pytest.approx(1e3 * curve.x_m[-1], abs=1e-4)
    with pytest.raises(BadInputError, match="no reading"):
        reading_curve(session, 0, 999)
    with pytest.raises(BadInputError, match="no such condition"):
        reading_curve(session, -1, 0)


def test_a_mean_along_the_sheet_in_a_model_file_has_no_interval_of_its_own(measured, fitted):
    sheet = fitted.varying_model.sheets["long"]
    assert len(sheet.eibm[2.0].values) > 1
    assert isinstance(sheet.eibm[2.0], Along)
    shown = result_of(measured, fitted=fitted, with_effects=fitted.varying_model)
    parameters = shown["configurations"][0]["parameters"]
    assert parameters["effects"]["EIBM_uNm"] == {}
    assert set(parameters["along"]["EIBM_uNm"]) == {"2.0", "-2.0"}


@pytest.mark.thorough
def test_bands_hold_about_90_percent_of_measurements_left_out_of_the_fit():
    """A small edition of `benchmarks.band_coverage`, which states the figures."""
    for name, inside in tally(load_world(None), range(900, 912)).items():
        assert np.mean(inside) > 0.75, name  # twelve independent set-ups
