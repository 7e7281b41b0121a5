"""What a sheet can do: the questions of the paper's section 5, checked against the definition."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import model.design.force_map as force_maps
from model import ModelError, Parameter, SheetModel
from model.design.force_map import force_map, resized, section
from model.design.linear_models import controller, fit_linear, linearise, state_space, validity
from model.design.propagation import propagate, varied
from model.design.sizing import least_area, linearity
from model.design.working_section import (
    best_line,
    force_both_ways,
    largest_forces,
    shape_difference,
    shortest_sheet,
)
from model.identification.baselines import MODELS, compare
from model.sheet.beam_problem import ActiveEffect

LOW, HIGH = 0.0, 0.03


@pytest.fixture(scope="module")
def unsure(truth: SheetModel) -> SheetModel:
    """The same sheets with 3 % on B and nothing else."""
    sheets = {
        name: replace(one, B=Parameter(value=one.B.value, sigma=0.03 * one.B.value, unit="N m^2"))
        for name, one in truth.sheets.items()
    }
    return SheetModel(sheets=sheets)


def test_an_uncertain_parameter_of_an_effect_is_carried_through(truth):
    def answer(sigma: float) -> Parameter:
        decay = Parameter(value=12.0, sigma=sigma, unit="mm")
        effect = ActiveEffect(name="nonuniform_eibm", parameters={"decay_length_mm": decay})
        model = truth.with_effects(effect)
        return best_line(model, "long", 0.0, 0.010, 2.0).at_zero_N

    known, unsure = answer(0.0), answer(0.5)
    assert unsure.value == known.value
    assert unsure.sigma > known.sigma + 1e-6


def test_questions_about_the_same_maps_solve_them_once(truth, monkeypatch):
    solved = []
    solve = force_maps.solved
    monkeypatch.setattr(force_maps, "solved", lambda setups: solved.append(1) or solve(setups))
    place = (truth, "long", 0.0, 0.010)
    alone = force_both_ways(*place), best_line(*place, 2.0)
    apart = len(solved)
    with force_maps.keeping_maps():
        together = force_both_ways(*place), best_line(*place, 2.0)
    assert together == alone
    assert 2 * (len(solved) - apart) <= apart


def test_kept_maps_are_those_of_a_session_and_of_a_measured_length(truth):
    own = {"session_1": 0.3, "session_2": -0.3}
    of_sessions = {name: Parameter(value=c, sigma=0.0, unit="") for name, c in own.items()}
    differs = truth.with_effects(ActiveEffect(name="session_eibm", parameters=of_sessions))
    falls = truth.with_effects(
        ActiveEffect(
            name="nonuniform_eibm",
            parameters={"decay_length_mm": Parameter(value=12.0, sigma=0.0, unit="mm")},
        )
    )
    cut = [replace(falls, cut_from_m={"long": length_m}) for length_m in (0.05, 0.1)]
    for pair in ([differs.in_session(1), differs.in_session(2)], cut):
        alone = [force_map(one, "long", 0.01, 2.0).tangential_N[0, 0] for one in pair]
        with force_maps.keeping_maps():
            kept = [force_map(one, "long", 0.01, 2.0).tangential_N[0, 0] for one in pair]
        assert alone[0] != alone[1]
        assert kept == alone


def test_the_best_line_of_the_short_sheet_fits_within_a_percent(unsure):
    line = best_line(unsure, "short", LOW, HIGH, 0.0)
    assert line.relative_error < 0.01
    p = section(LOW, HIGH)
    force = force_map(unsure, "short", p, 0.0).tangential_N[:, 0]
    slope, start = np.polyfit(p, force, 1)
    assert line.slope_N_per_m.value == pytest.approx(slope)
    assert line.at_zero_N.value == pytest.approx(start)
    assert line.range_N == pytest.approx(np.ptp(force))


def test_an_answer_in_proportion_to_the_stiffness_is_as_unsure_as_it(unsure):
    line = best_line(unsure, "long", LOW, HIGH, 2.0)
    for answer in (line.slope_N_per_m, line.at_zero_N):
        assert answer.sigma == pytest.approx(0.03 * abs(answer.value), rel=1e-3)
    forces = largest_forces(unsure, "long", LOW, HIGH)
    best = forces["tangent +"].force_N
    assert best.sigma == pytest.approx(0.03 * best.value, rel=1e-3)


def test_the_long_sheet_is_less_linear_than_the_short_one(truth):
    lines = {name: best_line(truth, name, LOW, HIGH, 0.0) for name in ("long", "short")}
    assert lines["long"].relative_error > 5.0 * lines["short"].relative_error


def test_the_short_sheet_keeps_its_shape_and_the_long_one_does_not(truth):
    long, short = (shape_difference(truth, name, LOW, HIGH) for name in ("long", "short"))
    assert long.distance_m.value > 20.0 * short.distance_m.value
    assert long.voltages_V == (-2.0, 2.0)
    assert LOW <= long.position_m <= HIGH


def test_the_shortest_sheet_just_reaches(truth):
    need = shortest_sheet(truth, "long", LOW, HIGH)
    p = section(LOW, HIGH)
    enough = resized(truth, "long", need.length_m.value + 1e-5, 0.0)
    assert force_map(enough, "long", p, (-2.0, 0.0, 2.0)).all_reachable()
    less = resized(truth, "long", need.length_m.value - 1e-4, 0.0)
    found = force_map(less, "long", [need.position_m], [need.voltage_V])
    assert not found.all_reachable()


def test_largest_forces_are_the_extremes_over_section_and_voltages(truth):
    found = force_map(truth, "long", section(LOW, HIGH), (-2.0, 0.0, 2.0))
    answers = largest_forces(truth, "long", LOW, HIGH)
    assert answers["tangent +"].force_N.value == pytest.approx(found.tangential_N.max())
    assert answers["tangent -"].force_N.value == pytest.approx(-found.tangential_N.min())
    assert answers["normal +"].force_N.value == pytest.approx(found.normal_N.max())
    N = np.hypot(found.tangential_N, found.normal_N)  # frictionless: all of it is along the normal
    assert np.all(np.abs(found.tangential_N) <= N)


def test_the_radial_force_of_a_straight_sheet_pulls_inward_on_the_object_it_bends_round():
    """Pushed to positive positions a straight sheet leans out, so that its normal points inward."""
    from model.mechanics.equilibrium import problems, solve
    from model.mechanics.field import Field

    found = solve(problems(Field.constant(0.0, 0.05), 0.5, 0.04))
    outward = found.nu * np.array([-np.sin(found.phi_hat_rad), np.cos(found.phi_hat_rad)])
    radial = outward[:, 0] @ np.array([np.cos(0.5), np.sin(0.5)])
    assert -found.nu[0] * np.sin(found.gamma_rad[0]) == pytest.approx(radial)


def test_force_both_ways_is_what_the_weaker_direction_gives(truth):
    answer = force_both_ways(truth, "short", 0.0, 0.01)
    found = force_map(truth, "short", section(0.0, 0.01), (-2.0, 0.0, 2.0)).tangential_N
    assert answer.force_N.value == pytest.approx(min(found.max(1).min(), (-found).max(1).min()))
    assert force_both_ways(truth, "short", 0.0, 0.03).force_N.value < answer.force_N.value


@pytest.mark.slow
def test_the_sheet_of_least_area_gives_the_force_and_no_smaller_one_does(truth):
    size = least_area(truth, "long", 0.01, 0.016, 5e-4, elongated=True)
    finite = size.areas_m2[np.isfinite(size.areas_m2)]
    assert size.area_m2.value <= np.min(finite) * (1.0 + 1e-12)
    assert size.area_m2.value == pytest.approx(size.length_m * size.width_m.value)
    share = size.width_m.value / truth.sheet("long").sheet.width_m
    cut = resized(truth, "long", size.length_m, size.elongation_m + 1e-4)
    force = share * force_map(cut, "long", section(0.01, 0.016, 31), (-2.0, 0.0, 2.0)).tangential_N
    assert min(force.max(1).min(), (-force).max(1).min()) == pytest.approx(5e-4, rel=1e-6)


@pytest.mark.slow
def test_an_elongation_saves_area_and_makes_the_force_linear(truth):
    sizes = [
        least_area(truth, "long", 0.01, 0.016, 5e-4, elongated=e, direction="positive")
        for e in (True, False)
    ]
    assert sizes[0].area_m2.value < 0.75 * sizes[1].area_m2.value
    assert sizes[1].elongation_m == 0.0
    assert sizes[1].length_m > 0.04
    errors = linearity(truth, "long", LOW, HIGH)
    assert np.all(np.diff(errors.relative_error) > 0.0)  # the longer the sheet, the less linear


@pytest.mark.slow
def test_a_force_that_cannot_be_had_is_an_error(truth):
    weak = SheetModel(sheets={"long": varied(truth.sheet("long"), 1.0, {2.0: 0.05, -2.0: 0.05})})
    with pytest.raises(ModelError, match="no sheet of this material"):
        least_area(weak, "long", 0.0, 0.03, 1e-3, elongated=False)


def test_questions_about_places_out_of_reach_are_errors(truth):
    with pytest.raises(ModelError, match="not reachable everywhere"):
        best_line(truth, "long", 0.0, 0.06, 2.0)
    with pytest.raises(ModelError, match="beginning below its end"):
        best_line(truth, "long", 0.03, 0.0, 2.0)


def test_uncertainties_of_stiffness_and_moment_are_carried_through(truth):
    one = truth.sheet("short")
    eibm = {v: replace(a, sigma=np.abs(a.values) * 0.05) for v, a in one.eibm.items()}
    model = SheetModel(
        sheets={"short": replace(one, B=replace(one.B, sigma=0.03 * one.B.value), eibm=eibm)}
    )
    (answer,) = propagate(model, "short", lambda m: [m.sheet("short").mean_eibm(2.0)], ("N m",))
    assert answer.sigma == pytest.approx(0.05 * abs(answer.value), rel=0.01)


@pytest.mark.parametrize("name", ["long", "short"])
def test_the_linear_model_is_tangent_to_the_full_one(truth, name):
    linear = linearise(truth, name, 0.01, 1.0)
    near = force_map(truth, name, [0.0099, 0.0101], [0.98, 1.02])
    p, V = near.position_m[:, None], near.voltage_V[None, :]
    np.testing.assert_allclose(linear.force(p, V), near.tangential_N, rtol=1e-4, atol=1e-8)


def test_the_validity_map_tells_where_the_linear_model_may_be_used(truth):
    short, error = fit_linear(truth, "short", LOW, HIGH)
    found = validity(truth, short, LOW, HIGH)
    assert np.sqrt(np.mean(found.error_N**2)) == pytest.approx(error, rel=0.05)
    assert found.valid(0.05).mean() > 0.95
    narrow = validity(truth, linearise(truth, "long", 0.0), LOW, HIGH)
    assert narrow.valid(0.01)[0, 4] == 1.0  # at its operating point
    assert narrow.valid(0.01).mean() < 0.6


@pytest.mark.parametrize(
    "ask", [lambda m: linearise(m, "long", 0.01), lambda m: fit_linear(m, "long", LOW, HIGH)]
)
def test_without_a_driving_voltage_there_is_no_linear_model(truth, ask):
    undriven = SheetModel(sheets={"long": replace(truth.sheet("long"), eibm={})})
    with pytest.raises(ModelError, match="'long' has no driving voltage"):
        ask(undriven)


@pytest.mark.parametrize("lag", [0.0, 0.03])
def test_the_controller_gives_the_wanted_response_on_the_state_space(truth, lag):
    linear, _ = fit_linear(truth, "short", LOW, HIGH)
    mass, w = 1e-3, 20.0
    system = state_space(linear, mass, 1e-4, lag)
    gains = controller(linear, mass, w, 1.0, 1e-4)
    feedback = np.zeros((1, system.A.shape[0]))
    feedback[0, 0] = gains.position_V_per_m - gains.feedforward_V_per_m
    feedback[0, 1] = gains.speed_Vs_per_m
    poles = np.linalg.eigvals(system.A - system.B @ feedback)
    assert np.all(poles.real < 0.0)
    if lag == 0.0:
        np.testing.assert_allclose(poles, -w, rtol=1e-4)
    # at rest at the middle of the section the feedforward holds the object still
    V = gains.feedforward_V + gains.feedforward_V_per_m * linear.position_m
    assert linear.force(np.array(linear.position_m), np.array(V)) == pytest.approx(0.0, abs=1e-12)


def test_a_controller_needs_a_mass(truth):
    linear = linearise(truth, "short", 0.01)
    with pytest.raises(ModelError, match="mass"):
        state_space(linear, 0.0)
    with pytest.raises(ModelError, match="positive mass"):
        controller(linear, -1.0, 20.0)


@pytest.mark.thorough
def test_simple_models_do_for_the_short_sheet_and_not_for_the_long_one(measure):
    rows = {(r.configuration, r.model): r for r in compare(measure(scatter=0.0))}
    assert len(rows) == 2 * (len(MODELS) + 1)
    full, line = (rows["long", name] for name in ("full model, constant EIBM", "linear beam"))
    assert full.curve_rmse_m < 5e-5
    assert line.curve_rmse_m > 10.0 * full.curve_rmse_m
    assert line.force_rmse_N > 2.0 * full.force_rmse_N
    assert rows["short", "linear beam"].curve_rmse_m < 2e-4
    assert rows["short", "constant curvature"].force_rmse_N < 2e-4


def test_simple_models_agree_with_the_full_one_at_small_deflections(measure, truth):
    from model.identification.observations import observe
    from model.mechanics.field import Field

    observed = observe(measure(), "long")
    nearly_straight = Field.constant(0.3, 0.05)
    answers = {n: m(observed, nearly_straight, 0.004)(0.2) for n, m in MODELS.items()}
    exact = answers["full model, constant EIBM"]
    line = answers["linear beam"]
    assert line.force_per_m2 == pytest.approx(exact.force_per_m2, rel=2e-3)
    np.testing.assert_allclose(np.interp(exact.x_m, line.x_m, line.y_m), exact.y_m, atol=1e-6)
