"""What a model says of a condition, and what it says when there is no answer."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from model import Along, ConfiguredSheet, ModelError, Parameter, SheetModel, predict
from model.mechanics.contact_range import limit_m, other_solutions, stable
from model.mechanics.equilibrium import problems, solve
from model.mechanics.field import Field
from model.sheet.beam_problem import ActiveEffect
from model.sheet.configured_sheet import FittedPositions

R = 0.04


def test_the_limit_of_reach_is_the_same_however_far_the_place_is_that_was_asked_for():
    near, far = (limit_m(problems(Field.constant(20, 0.05), at, R)) for at in (3.0, 2.5e7))
    assert far == pytest.approx(near, abs=1e-5)


@pytest.mark.parametrize(
    ("curvature", "limit_mm"), [(0, 54.1), (20, 49.3), (40, 45.85), (60, 44.3)]
)
def test_the_limit_of_reach_is_where_the_sheet_slips_out(curvature, limit_mm):
    limit, slips = limit_m(problems(Field.constant(curvature, 0.05), 1.5, R))
    assert slips
    assert limit * 1e3 == pytest.approx(limit_mm, abs=0.05)


def test_the_limit_is_that_of_the_first_problem_whatever_radii_the_others_have():
    one = problems(Field.constant(20, 0.05), 1.5, R)
    both = problems(Field.constant(20, 0.05), [1.5, 0.2], R)
    both = replace(both, radii_m=np.array([R, 0.03]), radius_m=0.03)
    assert limit_m(both) == pytest.approx(limit_m(one))


def test_an_unreachable_position_is_an_answer(truth: SheetModel):
    found = predict(truth, "long", 0.052, 2.0)
    assert not found.reachable
    assert found.why.startswith("not reachable: the sheet slips out at 4")
    assert np.isnan(found.F_N)
    answer = found.to_json()
    assert answer["F_N"] is None
    assert answer["x_mm"] == []
    json.dumps(answer, allow_nan=False)


def test_a_sheet_that_is_shorter_than_the_arc_is_far_is_said_to_be(truth: SheetModel):
    one = truth.sheet("long")
    far = replace(one, sheet=replace(one.sheet, arc_radius_m=0.2))
    found = predict(SheetModel(sheets={"long": far}), "long", 0.0, 2.0)
    assert not found.reachable
    assert "50 mm with its elongation, the arc's radius is 200 mm" in found.why


def test_a_sheet_without_a_driven_voltage_knows_0_V_alone(truth: SheetModel):
    model = SheetModel(sheets={"long": replace(truth.sheet("long"), eibm={})})
    with pytest.raises(ModelError, match=r"knows 0 V alone; \+2 V is outside"):
        predict(model, "long", 0.0, 2.0)


def test_a_prediction_holds_what_simulate_prints(truth: SheetModel):
    found = truth.predict("short", 0.005, 2.0)
    answer = found.to_json()
    assert set(answer) == {
        "configuration", "position_mm", "voltage_V", "reachable", "why", "F_N", "N_N", "s_hat_mm",
        "phi_hat_rad", "x_mm", "y_mm", "curvature_per_m",
    }  # fmt: skip
    assert answer["reachable"]
    assert answer["why"] == ""
    x, y = np.array(answer["x_mm"]), np.array(answer["y_mm"])
    assert np.hypot(x[-1], y[-1]) > 40.0
    assert np.max(np.hypot(np.diff(x), np.diff(y))) <= 0.5 + 1e-9
    angle, i = 5.0 / 40.0, int(np.argmin(abs(found.s_m - found.s_hat_m)))
    assert np.hypot(x[i] - 40 * np.cos(angle), y[i] - 40 * np.sin(angle)) < 0.3


def test_the_rest_positions_are_where_the_force_changes_sign(truth: SheetModel):
    for name, low, high in (("long", 0.013, 0.016), ("short", 0.004, 0.0055)):
        assert predict(truth, name, low, 0.0).F_N > 0.0 > predict(truth, name, high, 0.0).F_N


def test_a_voltage_between_those_fitted_gives_a_moment_in_proportion(truth: SheetModel):
    one = truth.sheet("long")
    assert one.mean_eibm(1.0) == pytest.approx(0.5 * one.mean_eibm(2.0), rel=1e-12)
    with pytest.raises(ModelError, match=r"knows -2 V to \+2 V; \+3 V is outside"):
        predict(truth, "long", 0.0, 3.0)


def test_a_position_beyond_those_fitted_is_predicted_with_a_remark(truth: SheetModel):
    model = replace(truth, fitted={"long": FittedPositions(0.0, 0.02)})
    assert predict(model, "long", 0.02, 2.0).why == ""
    assert predict(model, "long", 0.0203, 2.0).why == ""  # set by hand, it is the last one
    beyond = predict(model, "long", 0.03, 2.0)
    assert beyond.reachable
    assert beyond.why == "beyond the positions fitted (0 to 20 mm)"
    assert predict(model, "long", -0.005, 2.0).why == beyond.why
    alone = replace(truth, fitted={"long": FittedPositions(0.01, 0.01)})
    assert predict(alone, "long", 0.03, 2.0).why == "beyond the positions fitted (10 mm)"
    assert SheetModel.from_dict(model.to_dict()).fitted == model.fitted
    assert predict(truth, "long", 0.03, 2.0).why == ""  # nothing was fitted


def test_a_model_survives_being_written_and_read(truth: SheetModel):
    effect = ActiveEffect(
        name="gravity", parameters={"load_N_per_m": Parameter(value=1e-3, sigma=1e-4, unit="N/m")}
    )
    model = replace(
        truth.with_effects(effect), source="a.h5", checksum="ff", held_out=("long, 5 mm, +2 V",),
        merit={"force_rmse_N": 1e-4},
    )  # fmt: skip
    data = json.loads(json.dumps(model.to_dict()))
    again = SheetModel.from_dict(data)
    assert again.to_dict() == model.to_dict()
    assert again.effects == (effect,)
    plain = SheetModel.from_dict(truth.to_dict())
    one, two = (predict(m, "long", 0.01, -2.0) for m in (truth, plain))
    assert pytest.approx(two.F_N, rel=1e-13) == one.F_N


def test_an_effect_unknown_to_this_version_is_refused(truth: SheetModel):
    with pytest.raises(ModelError, match="unknown to this version"):
        predict(truth.with_effects(ActiveEffect(name="magnetism")), "long", 0.0, 0.0)
    theirs = ActiveEffect(name="magnetism", distribution="coils 2.0")
    with pytest.raises(ModelError, match=r"'magnetism' of coils 2\.0, which is not installed"):
        predict(truth.with_effects(theirs), "long", 0.0, 0.0)


@pytest.mark.parametrize(
    ("path", "value", "text"),
    [
        (("labrig_model",), 7, "the model file has format 7 .* use a newer labrig"),
        (("configurations", "long", "B_Nm2", "value"), -1.0, "must be positive"),
        (("configurations", "long", "B_Nm2", "value"), "many", "finite number is wanted"),
        (("configurations", "long", "B_Nm2", "sigma"), float("nan"), "finite number is wanted"),
        (("configurations", "long", "geometry", "free_length_mm"), 0.0, "free_length_mm"),
        (("configurations", "long", "eibm"), {"two": {}}, "not a voltage"),
        (("configurations", "long", "initial_curvature", "value"), [1.0], "equally long"),
        (("configurations", "long", "fitted_positions_mm"), [1.0], "least and the largest"),
        (("configurations", "long", "fitted_positions_mm"), [2.0, 1.0], "least position comes"),
        (("configurations", "long", "fitted_positions_mm"), [0.0, "x"], "finite number"),
        (("effects",), [{"parameters": {}}], "a table with a name"),
        (("configurations",), 3, "a table is wanted"),
    ],
)
def test_a_broken_model_file_is_refused_with_its_key(truth: SheetModel, path, value, text):
    data = json.loads(json.dumps(truth.to_dict()))
    place = data
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    with pytest.raises(ModelError, match=text):
        SheetModel.from_dict(data)


def test_the_branch_continued_from_the_free_shape_is_stable():
    for length, curvature, beta in ((0.05, 20, 0.3), (0.0045, 28, 0.2), (0.05, 60, 0.5)):
        assert stable(solve(problems(Field.constant(curvature, length), beta, R, 0.05)))


def test_a_long_elongation_can_be_wound_round_and_that_is_said():
    batch = problems(Field.constant(60.0, 0.05), 0.5, R, 0.05)
    others = other_solutions(solve(batch))
    assert any(nu * R * R == pytest.approx(-3.29, abs=0.01) for nu in others)
    assert other_solutions(solve(problems(Field.constant(60.0, 0.05), 0.5, R))) == []


def test_further_solutions_are_those_of_the_first_problem_whatever_radii_the_others_have():
    one = problems(Field.constant(60.0, 0.05), 0.5, R, 0.05)
    both = problems(Field.constant(60.0, 0.05), [0.5, 0.4], R, 0.05)
    both = replace(both, radii_m=np.array([R, 0.03]), radius_m=0.03)
    assert other_solutions(solve(both)) == pytest.approx(other_solutions(solve(one)), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("length", "curvature"), [(0.05, 20.0), (0.02, 60.0)])
def test_every_neighbouring_shape_through_the_contact_has_more_energy(length, curvature):
    """The elastic energy itself, by brute force, where `stable` looks at its second variation."""
    beta = 0.6
    found = solve(problems(Field.constant(curvature, length), beta, R, 10.0, accuracy="reference"))
    top, beyond = float(found.l_hat_m[0]), float(found.s_hat_m[0] - found.l_hat_m[0])
    s = np.linspace(0.0, top, 1501)
    middle, h = 0.5 * (s[1:] + s[:-1]), s[1]
    phi = found.shapes(middle).phi_rad[0]
    modes = np.stack([np.sin((m - 0.5) * np.pi * middle / top) for m in range(1, 9)])
    slopes = np.stack(
        [(m - 0.5) * np.pi / top * np.cos((m - 0.5) * np.pi * middle / top) for m in range(1, 9)]
    )
    bent = found.shapes(middle).curvature_per_m[0] - curvature

    def misses(free, c):
        eta = np.array([*free[:2], *c]) @ modes
        end = phi[-1] + eta[-1]
        x = h * np.sum(np.cos(phi + eta)) + (beyond + free[2]) * np.cos(end)
        y = h * np.sum(np.sin(phi + eta)) + (beyond + free[2]) * np.sin(end)
        return np.array([x, y])

    def energy(free, c):
        return 0.5 * h * np.sum((bent + np.array([*free[:2], *c]) @ slopes) ** 2)

    random = np.random.default_rng(0)
    aim, at_rest = misses(np.zeros(3), np.zeros(6)), energy(np.zeros(3), np.zeros(6))
    assert stable(found)
    for _ in range(20):
        c = 0.03 * random.standard_normal(6)
        lowest = np.inf
        for slide in np.linspace(-2e-3, 2e-3, 9):
            free = np.array([0.0, 0.0, slide])
            for _ in range(20):
                miss = misses(free, c) - aim
                J = (
                    np.stack([misses(free + d, c) - aim - miss for d in np.eye(3)[:2] * 1e-7]).T
                    / 1e-7
                )
                free[:2] -= np.linalg.solve(J, miss)
            lowest = min(lowest, energy(free, c))
        assert lowest > at_rest


@pytest.mark.parametrize(
    ("kappa", "angle", "radius", "text"),
    [
        (Field.constant(np.nan, 0.05), 0.1, R, "not finite"),
        (Field.constant(1.0, 0.05), np.nan, R, "not a finite number"),
        (Field.constant(1.0, 0.05), 0.1, -R, "radius must be positive"),
    ],
)
def test_a_meaningless_problem_is_refused(kappa, angle, radius, text):
    with pytest.raises(ModelError, match=text):
        problems(kappa, angle, radius)


def test_a_stiffness_that_is_not_positive_is_refused():
    soft = Field.linear(np.array([0.0, 0.05]), np.array([1.0, -0.2]), 0.05)
    with pytest.raises(ModelError, match="stiffness must be positive"):
        problems(Field.constant(1.0, 0.05), 0.1, R, 0.0, soft)


def test_places_along_the_sheet_must_ascend():
    with pytest.raises(ModelError, match="must ascend"):
        Field.linear(np.array([0.0, 0.02, 0.01]), np.ones(3), 0.05)


def test_a_sheet_softer_towards_its_end_bends_where_it_is_soft(truth: SheetModel):
    from model.sheet.beam_problem import ConditionProblem
    from model.sheet.solution import free_curvature

    one: ConfiguredSheet = truth.sheet("long")
    soft = Field.linear(np.array([0.0, 0.05]), np.array([1.0, 3.0]), 0.05)
    setup = ConditionProblem(
        sheet=one.sheet,
        voltage_V=2.0,
        angle_rad=0.1,
        B_Nm2=one.B.value,
        rest=Field.constant(5.0, 0.05),
        eibm=one.eibm_at(2.0),
        softness=soft,
    )
    kappa, s = free_curvature(setup), np.linspace(0.0, 0.05, 11)
    np.testing.assert_allclose(kappa(s), 5.0 + 25.0 * soft(s), rtol=1e-12)
    assert isinstance(one.eibm[2.0], Along)


def test_an_elongation_that_bends_at_one_voltage_alone_is_rigid_at_the_others(truth: SheetModel):
    from model.sheet.beam_problem import ConditionProblem
    from model.sheet.solution import solved

    one: ConfiguredSheet = truth.sheet("short")
    assert one.sheet.elongation_m > 0

    def setup(elongation_soft: float) -> ConditionProblem:
        return ConditionProblem(
            sheet=one.sheet,
            voltage_V=2.0,
            angle_rad=0.1,
            B_Nm2=one.B.value,
            rest=Field.constant(5.0, one.sheet.free_length_m),
            eibm=one.eibm_at(2.0),
            elongation_soft=elongation_soft,
        )

    rigid = solved([setup(0.0)]).nu[0]
    together = solved([setup(soft) for soft in (0.3, 0.0, -0.1)]).nu  # less than rigid: rigid
    assert abs(together[0] / rigid - 1) > 1e-3
    np.testing.assert_allclose(together[1:], rigid, rtol=1e-5)
