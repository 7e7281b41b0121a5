"""Identification finds what the data were made with, and says how sure it is."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from model import Along, ConfiguredSheet, FitOptions, Parameter, SheetModel, fit
from model.identification.observations import observe
from model.identification.paper import identify
from model.identification.residuals import against
from model.mechanics.equilibrium import problems, solve
from model.mechanics.field import Field
from model.sheet.configured_sheet import FittedPositions
from tests.cases import few

LONG_B, SHORT_B = 1.27e-6, 8.5e-7


def stated_k0(model: SheetModel, name: str) -> Field:
    sheet = model.sheet(name).sheet
    assert sheet.initial_curvature is not None
    return Field.linear(*sheet.initial_curvature, sheet.free_length_m)


@pytest.mark.slow
def test_exact_data_give_back_the_exact_parameters(truth, measure):
    exact = measure(force_N=0.0, curve_m=0.0, scatter=0.0)
    found = fit(exact, FitOptions(eibm_form="constant", initial_curvature_sigma_per_m=0.0))
    for name, B in (("long", LONG_B), ("short", SHORT_B)):
        one = found.configurations[name]
        assert one.B.value == pytest.approx(B, rel=1e-5)
        for voltage, along in truth.sheet(name).eibm.items():
            assert one.eibm[voltage].value == pytest.approx(along.values[0], rel=1e-5)
    assert found.rmse["constant"].force_N < 1e-8
    assert found.rmse["constant"].curve_m < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize(
    ("k0_per_m", "bend_per_m", "radius_m"),
    few([(20.0, 63.0, 0.025), (80.0, 28.0, 0.02), (50.0, -49.0, 0.029)]),
)
def test_a_sheet_that_is_bent_to_a_ring_is_fitted(truth, measure, k0_per_m, bend_per_m, radius_m):
    """Beyond its end there would be another equilibrium, of a longer sheet."""
    long = truth.sheet("long")
    rest = (np.zeros(1), np.array([k0_per_m]))
    sheet = replace(long.sheet, arc_radius_m=radius_m, initial_curvature=rest)
    eibm = {
        sign * 2.0: Along.constant(
            Parameter(value=sign * LONG_B * bend_per_m, sigma=0.0, unit="N m")
        )
        for sign in (1.0, -1.0)
    }
    along = Along(*rest, np.zeros(1), "1/m")
    bent = SheetModel(sheets={"long": ConfiguredSheet(sheet, long.B, along, eibm)})
    places = (0, 5, 10, 15)
    found = fit(measure(names=("long",), positions_mm=places, scatter=0.0, model=bent))
    one = found.configurations["long"]
    assert one.B.value == pytest.approx(LONG_B, rel=0.01)
    assert one.eibm[2.0].value == pytest.approx(LONG_B * bend_per_m, rel=0.01)
    assert found.rmse["constant"].curve_m < 3e-5


@pytest.mark.thorough
@pytest.mark.slow
def test_noisy_data_give_parameters_within_their_stated_uncertainty(truth, measure):
    found = fit(measure(seed=1))
    for name, B in (("long", LONG_B), ("short", SHORT_B)):
        one = found.configurations[name]
        assert abs(one.B.value - B) < 3.0 * one.B.sigma < 0.06 * B
        for voltage, along in truth.sheet(name).eibm.items():
            here = one.eibm[voltage]
            assert abs(here.value - along.values[0]) < 3.5 * here.sigma
            assert here.sigma < 0.04 * abs(here.value)
    assert 0.003 < found.scatter["eibm"] < 0.03
    assert 0.003 < found.scatter["stiffness"] < 0.03


@pytest.mark.slow
def test_the_paper_s_formulas_give_the_same_within_their_scatter(truth, measure):
    data = measure(seed=2)
    for name, B in (("long", LONG_B), ("short", SHORT_B)):
        one = identify(observe(data, name), stated_k0(truth, name))
        assert one.B_Nm2 == pytest.approx(B, rel=0.05)
        for voltage, along in truth.sheet(name).eibm.items():
            assert one.eibm_Nm[voltage] == pytest.approx(along.values[0], rel=0.05)
        middle = one.s_m < 0.8 * one.s_m[-1]
        rms = np.sqrt(
            np.mean((one.eibm_along_Nm[2.0][middle] / along_value(truth, name) - 1.0) ** 2)
        )
        assert rms < 0.15


def along_value(model: SheetModel, name: str) -> float:
    return float(model.sheet(name).eibm[2.0].values[0])


def test_equation_7_leaves_out_moments_below_their_uncertainty_and_weighs_the_rest(truth, measure):
    rest_curvature = stated_k0(truth, "short")
    angle = brentq(  # the sheet passes there without a force
        lambda angle: solve(problems(rest_curvature, angle, 0.04, 0.04)).force(1.0)[0], -1.0, 1.0
    )
    positions = (0.0, angle * 40.0, 10.0, 20.0)
    data = observe(measure(seed=3, names=("short",), positions_mm=positions, scatter=0.0), "short")
    flat, steep = (identify(data, rest_curvature, q) for q in (0.0, 2.0))
    rest = [s for s in flat.samples if s.observation.voltage_V == 0.0]
    assert [np.isnan(s.B_Nm2) for s in rest] == [False, True, False, False]
    used = [s for s in steep.samples if s.weight > 0.0]
    weights = np.array([s.weight for s in used])
    moments = np.array([abs(s.mean_moment_Nm) for s in used])
    np.testing.assert_allclose(weights, moments**2)
    assert steep.B_Nm2 == pytest.approx(float(weights @ [s.B_Nm2 for s in used] / weights.sum()))


@pytest.fixture(scope="module")
def falling(truth) -> SheetModel:
    """The long sheet with an EIBM that falls along it."""
    one = truth.sheet("long")
    s = np.linspace(0.0, 0.05, 26)
    eibm = {
        v: Along(s, LONG_B * c * np.exp(-s / 0.012), 0.0 * s, "N m")
        for v, c in ((2.0, 100.0), (-2.0, -80.0))
    }
    return SheetModel(sheets={"long": ConfiguredSheet(one.sheet, one.B, one.rest, eibm)})


@pytest.mark.slow
def test_the_constant_eibm_of_a_falling_one_is_its_mean_up_to_the_contact(falling, measure):
    found = fit(measure(seed=4, names=("long",), model=falling))
    one = found.configurations["long"]
    reach = 0.0415  # about where the sheet touches at +2 V
    mean = LONG_B * 100.0 * 0.012 / reach * (1.0 - np.exp(-reach / 0.012))
    assert one.eibm[2.0].value == pytest.approx(mean, rel=0.03)
    whole = LONG_B * 100.0 * 0.012 / 0.05 * (1.0 - np.exp(-0.05 / 0.012))
    assert one.eibm_mean[2.0].value == pytest.approx(whole, rel=0.03)
    assert one.B.value == pytest.approx(LONG_B, rel=0.03)
    values, sigma = one.eibm_along_Nm[2.0]
    true = LONG_B * 100.0 * np.exp(-one.s_m / 0.012)
    assert np.all(np.abs(values - true) < 5.0 * sigma + 0.02 * true[0])
    assert one.rmse["varying"].curve_m < 0.2 * one.rmse["constant"].curve_m
    assert one.rmse["varying"].force_N < 0.5 * one.rmse["constant"].force_N


@pytest.mark.thorough
@pytest.mark.slow
def test_json_has_exactly_the_agreed_keys(measure):
    answer = fit(measure(seed=5, names=("short",))).to_json()
    assert set(answer) == {"configurations", "rmse"}
    assert set(answer["rmse"]) == {"force_mN", "curve_mm"}
    short = answer["configurations"]["short"]
    assert set(short) == {"B_Nm2", "E_Pa", "EIBM_Nm", "EIBM_along_sheet"}
    assert set(short["EIBM_Nm"]) == {"2.0", "-2.0"}
    assert set(short["B_Nm2"]) == {"value", "sigma", "interval90"}
    low, high = short["B_Nm2"]["interval90"]
    assert low < short["B_Nm2"]["value"] < high
    assert set(short["EIBM_along_sheet"]["2.0"]) == {"s_mm", "Me_Nm", "sigma"}
    json.dumps(answer, allow_nan=False)


@pytest.mark.slow
def test_the_model_of_a_fit_predicts_what_the_fit_says(measure):
    data = measure(seed=6, names=("long",))
    found = fit(data)
    again = SheetModel.from_dict(json.loads(json.dumps(found.varying_model.to_dict())))
    answers = against(observe(data, "long"), again)
    for row, answer in zip(found.residuals, answers, strict=True):
        assert answer.force_N == pytest.approx(row.predicted_N["varying"], rel=1e-9)
    assert found.model.source == "made"
    assert found.model.merit["force_rmse_N"] == found.rmse["constant"].force_N


@pytest.mark.slow
def test_measured_rest_curvature_is_found_from_the_curves(truth, measure):
    for free in (False, True):
        found = fit(
            measure(seed=7, names=("long",), free=free), FitOptions(measured_curvature=True)
        )
        one = found.configurations["long"]
        inner = (one.s_m > 0.003) & (one.s_m < 0.04)
        assert np.max(np.abs(one.rest_per_m - stated_k0(truth, "long")(one.s_m))[inner]) < 1.0
        assert one.B.value == pytest.approx(LONG_B, rel=0.04)


@pytest.mark.slow
def test_a_wrong_stated_curvature_is_noted_and_hardly_moves_the_stiffness(truth, measure):
    data = measure(seed=8, names=("short",))
    sheet = data.sheets["short"]
    wrong = replace(sheet, initial_curvature=(np.zeros(1), np.array([26.5])))
    found = fit(replace(data, sheets={"short": wrong}))
    assert found.configurations["short"].B.value == pytest.approx(SHORT_B, rel=0.03)
    assert any("differ from the stated initial curvature" in note for note in found.notes)


@pytest.mark.thorough
@pytest.mark.slow
def test_one_eibm_for_both_polarities_when_asked(measure, truth):
    one = truth.sheet("short")
    even = {
        v: Along.constant(Parameter(value=np.sign(v) * 6e-5, sigma=0.0, unit="N m"))
        for v in (2.0, -2.0)
    }
    model = SheetModel(sheets={"short": ConfiguredSheet(one.sheet, one.B, one.rest, even)})
    found = fit(measure(seed=9, names=("short",), model=model), FitOptions(symmetric=True))
    eibm = found.configurations["short"].eibm
    assert eibm[2.0].value == pytest.approx(6e-5, rel=0.03)
    along = found.configurations["short"].eibm_along_Nm
    np.testing.assert_allclose(along[2.0][0], -along[-2.0][0])


@pytest.mark.slow
def test_forces_alone_give_stiffness_and_constant_eibm(measure, truth):
    found = fit(measure(seed=10, curves=False))
    for name, B in (("long", LONG_B), ("short", SHORT_B)):
        one = found.configurations[name]
        assert one.paper is None
        assert abs(one.B.value - B) < 4.0 * one.B.sigma
    assert np.isnan(found.rmse["constant"].curve_m)


@pytest.mark.slow
def test_why_there_are_no_parameters_condition_by_condition_is_a_note(measure):
    data = measure(seed=10, names=("short",))
    blind = (replace(c, curve=None) if c.voltage_V == 0.0 else c for c in data.conditions)
    found = fit(replace(data, conditions=tuple(blind)))
    assert found.configurations["short"].paper is None
    (note,) = (n for n in found.notes if "condition by condition" in n)
    assert "needs force and curve at 0 V" in note


@pytest.mark.slow
def test_held_out_conditions_are_not_used_and_are_named(measure):
    data = measure(seed=11, names=("short",))
    found = fit(data, FitOptions(held_out=(("short", 0.01), ("short", 0.02, 2.0))))
    assert len(found.residuals) == 21 - 4
    assert found.model.held_out[0] == "short, 10 mm, 0 V"
    assert found.model.held_out[-1] == "short, 20 mm, +2 V"


@pytest.mark.slow
def test_the_model_says_between_which_positions_it_was_fitted(measure):
    data = measure(seed=11, names=("short",))
    positions = sorted({c.position_m for c in data.conditions})
    found = fit(data, FitOptions(held_out=(("short", positions[-1]),)))
    assert found.model.fitted["short"] == FittedPositions(positions[0], positions[-2])


@pytest.mark.thorough
def test_simulated_repeats_confirm_the_stated_uncertainty(measure):
    found = fit(measure(seed=12), FitOptions(bootstrap=60))
    assert set(found.bootstrap_ratio) >= {"long B", "short EIBM at +2 V"}
    for ratio in found.bootstrap_ratio.values():
        assert 0.7 < ratio < 1.4


@pytest.mark.slow
def test_curves_that_scatter_are_not_said_to_differ_from_the_stated_curvature(truth, measure):
    one, k0 = truth.sheet("long"), np.zeros(1)
    sheet = replace(one.sheet, initial_curvature=(k0, k0))
    straight = replace(one, sheet=sheet, rest=Along(k0, k0, k0, "1/m"))
    model = SheetModel(sheets={"long": straight})
    found = fit(measure(names=("long",), positions_mm=(0, 10), curve_m=1e-4, model=model))
    assert not any("stated initial curvature" in note for note in found.notes)


@pytest.mark.slow
def test_what_cannot_be_negative_has_no_interval_below_zero(measure):
    found = fit(measure(names=("short",), positions_mm=(10,), force_N=3e-3))
    one = found.configurations["short"]
    for parameter in (one.B, one.B_per_width, one.E, one.eibm_mean_abs):
        assert replace(parameter, sigma=parameter.value).interval()[0] >= 0.0


@pytest.mark.slow
def test_where_a_model_has_no_equilibrium_is_one_sentence(measure, monkeypatch):
    def nowhere(observed, model):
        answer = SimpleNamespace(force_N=np.nan, curve_m=np.nan, why="has no equilibrium")
        return [answer] * len(observed.observations)

    monkeypatch.setattr("model.identification.residuals.against", nowhere)
    found = fit(measure(names=("short",), positions_mm=(0, 10)))
    told = [note for note in found.notes if "equilibrium" in note]
    assert len(told) == 2
    assert told[0].startswith("with a constant EIBM the model has no equilibrium at short, 0 mm, ")
    assert told[0].endswith("not in its errors, and its parameters are not to be trusted")
