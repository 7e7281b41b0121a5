"""Effects that need no solver, against what can be worked out by hand; and the sense of each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.effects import catalogue, effect
from model.effects._loop import hung
from model.effects._memory import lagging
from model.effects.conformance import plausible
from model.effects.interface import AcquisitionTimes, LoadCellInput
from model.effects.nonlinear_stiffness import bent, bent_by_power, exponent
from model.effects.sliding import slid
from model.effects.viscoelastic_creep import strains
from model.locations.examples import (
    LENGTH_M,
    NODES,
    RADIUS_M,
    example_beam,
    example_clock,
    example_points,
    example_pulse,
    example_sheet,
    example_weighed,
)
from model.mechanics.collocation import rule
from model.mechanics.equilibrium import check_softness
from model.sheet import applied_effects
from model.sheet.effect_hooks import Acting, course

WEIGHTS = np.polynomial.legendre.leggauss(NODES)[1] / 2.0  # of a mean over the nodes


def values(name: str, **own: float) -> dict[str, float]:
    return {**plausible(effect(name)), **own}


# --------------------------------------------------------------------------------- along the sheet


@pytest.mark.parametrize("decay_mm", [3.5, 8.0, 35.0, 120.0, 1e5, 1e9, np.inf])
def test_eibm_that_falls_keeps_its_mean_and_falls_by_the_ratio(decay_mm: float):
    beam, contact = example_beam()
    fall = effect("nonuniform_eibm")
    p = values("nonuniform_eibm", decay_length_mm=decay_mm)
    other = fall.beam(beam, contact, p).eibm
    assert other @ WEIGHTS == pytest.approx(beam.eibm @ WEIGHTS, rel=1e-4)
    ratio = fall.derived(p, example_sheet())["end_to_root_ratio"]
    assert ratio == pytest.approx(np.exp(-50.0 / decay_mm))
    inside = np.exp(-(beam.s_m[-1] - beam.s_m[0]) / (decay_mm * 1e-3))
    assert other[1, -1] / other[1, 0] == pytest.approx(inside)


def test_a_stiffness_that_grows_makes_the_end_softer_by_less_than_the_root():
    beam, contact = example_beam()
    soft = effect("nonuniform_stiffness").beam(beam, contact, {"relative_change": 0.4}).soft
    at = beam.s_m / LENGTH_M
    assert soft[2] == pytest.approx(1.2 / (1.0 + 0.4 * at))
    assert soft[0, 0] > 1.0 > soft[0, -1]


@pytest.mark.parametrize("change", [-0.2, -0.05, 0.05, 0.5, 1.0])
def test_the_nonlinear_law_is_inverted(change: float):
    linear = np.concatenate([-np.geomspace(1e-40, 3e3, 60), [0.0], np.geomspace(1e-9, 3e3, 60)])
    n = exponent(change)
    u = bent(linear, n)
    assert u * (1.0 + (u / 10.0) ** 2) ** n == pytest.approx(linear, rel=1e-11, abs=0.0)


def test_stiffness_at_ten_per_metre_has_changed_by_what_the_parameter_says():
    at_ten = 10.0 * 1.3  # the moment over B that bends a sheet by 10 per m when 30 % stiffer there
    assert bent(np.array([at_ten]), exponent(0.3)) == pytest.approx(10.0, rel=1e-13)


@pytest.mark.parametrize("power", [1.0, 2.0])
@pytest.mark.parametrize("change", [-0.2, -0.02, 0.0, 0.05, 1.0])
def test_a_stiffness_that_goes_with_a_power_of_the_bending_is_inverted(change: float, power: float):
    linear = np.concatenate([-np.geomspace(1e-9, 9.0, 40), [0.0], np.geomspace(1e-9, 9.0, 40)])
    u, slope = bent_by_power(linear, change, power)

    def law(u):
        c = change if change >= 0.0 else (1.0 + change) ** -power - 1.0
        grown = 1.0 + c * (np.abs(u) / 10.0) ** power
        return u * (grown if change >= 0.0 else grown ** (-1.0 / power))

    assert law(u) == pytest.approx(linear, rel=1e-12)
    h = 1e-4 * np.abs(u) + 1e-12
    assert slope == pytest.approx((law(u + h) - law(u - h)) / (2.0 * h), rel=1e-6)
    at_ten = np.array([10.0 * (1.0 + change)])
    assert bent_by_power(at_ten, change, power)[0] == pytest.approx(10.0)


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_a_sheet_that_softens_with_a_power_of_the_bending_does_not_give_way(power: float):
    u, slope = bent_by_power(np.array([1e3, 1e6]), -0.2, power)
    assert np.all(np.isfinite(u))
    assert np.all(slope > 0.0)


def test_a_nonlinear_sheet_bends_by_the_law_under_all_its_moments():
    beam, contact = example_beam()
    beam = replace(beam, bend=beam.bend + 1.5, soft=beam.soft * 0.9)
    p = {"relative_change_at_10_per_m": 0.3, "power": 0.0}
    other = effect("nonlinear_stiffness").beam(beam, contact, p)
    by_contact = -np.nan_to_num(contact.normal_N / beam.stiffness)[:, None] * contact.lever
    change = other.soft * (other.eibm + other.bend + by_contact)  # k - k0
    law = change * (1.0 + (change / 10.0) ** 2) ** np.log2(1.3)
    assert law == pytest.approx(beam.soft * (beam.eibm + beam.bend + by_contact), rel=1e-10)
    assert np.all(
        np.abs(change) < np.abs(beam.soft * (beam.eibm + beam.bend + by_contact))
    )  # stiffer
    assert np.all(other.soft < beam.soft)


def test_gravity_bends_a_straight_level_cantilever_as_in_the_textbook():
    beam, contact = example_beam()
    s, flat = beam.s_m, np.zeros_like(contact.x_m)
    sheet = replace(beam.sheet, elongation_m=0.0)
    contact = replace(contact, x_m=flat + s, y_m=flat, phi_rad=flat, end_phi_rad=np.zeros(7))
    bend = effect("gravity").beam(replace(beam, sheet=sheet), contact, {"load_N_per_m": 0.01}).bend
    wanted = -0.01 * (LENGTH_M - s) ** 2 / 2.0
    assert bend * beam.stiffness[:, None] == pytest.approx(flat + wanted, rel=1e-12)
    bend = effect("gravity").beam(beam, contact, {"load_N_per_m": 0.01}).bend  # 20 mm more
    wanted = -0.01 * (LENGTH_M + 0.02 - s) ** 2 / 2.0
    assert bend * beam.stiffness[:, None] == pytest.approx(flat + wanted, rel=1e-12)


def test_the_weight_of_a_bent_sheet_counts_with_its_arm():
    beam, contact = example_beam()
    bend = effect("gravity").beam(beam, contact, {"load_N_per_m": 0.01}).bend
    k, s, end = 45.0, beam.s_m, LENGTH_M
    x, cos_end = np.sin(k * s) / k, np.cos(k * end)
    on_sheet = (np.cos(k * s) - cos_end) / k**2 - (end - s) * x
    tail = 0.02 * (np.sin(k * end) / k - x) + 0.5 * 0.02**2 * cos_end
    moment = bend[6] * beam.stiffness[6]
    assert moment == pytest.approx(-0.01 * (on_sheet + tail), rel=2e-3)


def test_the_weight_changes_sides_where_the_rig_is_turned_over_and_nothing_else_does():
    beam, contact = example_beam()
    turned = replace(beam, upright=np.array([1.0, -1, 1, -1, 1, -1, 0.5]))
    for one in catalogue().values():
        before, after = (one.beam(b, contact, plausible(one)) for b in (beam, turned))
        for name in ("rest", "eibm", "soft", "shift_m", "tilt_rad", "offset_m", "stiffness"):
            np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
        sign = turned.upright[:, None] if one.name == "gravity" else 1.0
        np.testing.assert_allclose(after.bend, sign * before.bend, rtol=1e-14)


# --------------------------------------------------------------------------- clamp, contact, object


def test_the_clamp_turns_by_the_loads_moment_about_it():
    beam, contact = example_beam()
    tilt = effect("clamp_compliance").beam(beam, contact, {"rotation_rad_per_Nm": 20.0}).tilt_rad
    moment = -contact.force_N * RADIUS_M  # of the force on the sheet: it answers the push it gives
    assert tilt[:6] == pytest.approx(20.0 * moment[:6])
    assert tilt[6] == 0.0
    phi_hat = contact.gamma_rad + beam.stated_m / RADIUS_M
    to_node = contact.x_m[:, 0] * np.cos(phi_hat) + contact.y_m[:, 0] * np.sin(phi_hat)
    by_lever = -contact.normal_N * (contact.lever[:, 0] + to_node)
    assert moment[:6] == pytest.approx(by_lever[:6], rel=1e-12)


def test_the_load_cell_gives_way_where_it_is_pushed():
    beam, contact = example_beam()
    shift = (
        effect("load_cell_compliance").beam(beam, contact, {"compliance_mm_per_mN": 0.01}).shift_m
    )
    assert shift[:6] * 1e3 == pytest.approx(0.01 * contact.force_N[:6] * 1e3)
    assert shift[6] == 0.0


@pytest.mark.parametrize(
    ("name", "p", "field", "wanted"),
    [
        ("initial_curvature", {"curvature_error_per_m": 1.5}, "rest", 1.5),
        ("clamp_angle", {"angle_rad": 0.02}, "tilt_rad", 0.02),
        ("position_error", {"offset_mm": 0.4}, "shift_m", 4e-4),
        ("roll_offset", {"offset_mm": 0.4, "at_the_pressed": 0.0}, "offset_m", 4e-4),
        (
            "elongation_flexibility",
            {"relative_compliance": 0.03, "in_the_joint": 0.0},
            "elongation_soft",
            0.03,
        ),
    ],
)
def test_what_is_simply_added(name, p, field, wanted):
    beam, contact = example_beam()
    before = replace(beam, **{field: getattr(beam, field) + 0.25})
    after = getattr(effect(name).beam(before, contact, values(name, **p)), field)
    assert after == pytest.approx(getattr(before, field) + wanted)


def test_without_an_elongation_none_can_give_way():
    beam, contact = example_beam()
    beam = replace(beam, sheet=replace(beam.sheet, elongation_m=0.0))
    assert (
        effect("elongation_flexibility").beam(beam, contact, {"relative_compliance": 1.0}) is beam
    )


def test_the_asymmetry_adds_at_one_polarity_what_it_takes_from_the_other():
    beam, contact = example_beam()
    p = values("eibm_asymmetry", ratio=0.8)
    other = effect("eibm_asymmetry").beam(beam, contact, p).eibm
    np.testing.assert_allclose(other[2], -0.8 * other[1])
    np.testing.assert_allclose(other[1] - other[2], beam.eibm[1] - beam.eibm[2])
    assert not np.any(other[beam.voltage_V == 0.0])
    falling = effect("eibm_asymmetry").beam(beam, contact, {**p, "fall_mm": 25.0}).eibm
    assert falling @ WEIGHTS == pytest.approx(other @ WEIGHTS)
    more, length_m = falling[1] / beam.eibm[1] - 1.0, beam.s_m[-1] - beam.s_m[0]
    assert more[-1] / more[0] == pytest.approx(np.exp(-length_m / 0.025))


def test_an_asymmetry_of_one_side_leaves_the_other_polarity_as_it_is():
    beam, contact = example_beam()
    p = values("eibm_asymmetry", ratio=0.8) | {"fall_mm": 25.0, "side": -1.0}
    other = effect("eibm_asymmetry").beam(beam, contact, p).eibm
    below = beam.voltage_V < 0.0
    np.testing.assert_array_equal(other[~below], beam.eibm[~below])
    both = effect("eibm_asymmetry").beam(beam, contact, {**p, "side": 0.0}).eibm
    np.testing.assert_allclose((other - beam.eibm)[below], 2.0 * (both - beam.eibm)[below])


def test_beside_an_eibm_of_each_polarity_only_what_is_uneven_is_looked_for():
    whole = effect("eibm_asymmetry")
    left = whole.outside_base()
    assert left is not None
    assert left.parameters[1].starting_values == (25.0,)
    assert left.parameters[2].starting_values == (0.0, 1.0, -1.0)
    assert effect("gravity").outside_base() is effect("gravity")


def test_a_hinge_at_the_joint_turns_by_what_lets_the_contact_go_as_far():
    beam, contact = example_beam()
    p = {"relative_compliance": 0.03, "in_the_joint": 1.0}
    other = effect("elongation_flexibility").beam(beam, contact, p)
    turn = np.sum((other.soft - beam.soft) * beam.piece_m, axis=1)  # rad for each N m over B
    lever = beam.sheet.arc_radius_m - beam.sheet.free_length_m
    np.testing.assert_allclose(turn * lever**2, 0.03 * lever**3 / 3.0)
    # near the end, by a polynomial that the nodes of either configuration have exactly
    at = np.sum((other.soft - beam.soft) * beam.piece_m * beam.s_m, axis=1) / turn
    np.testing.assert_allclose(at, 6.0 / 7.0 * beam.sheet.free_length_m)
    # the EIBM does not turn it
    np.testing.assert_allclose(
        other.rest + other.soft * (other.eibm + other.bend),
        beam.rest + beam.soft * (beam.eibm + beam.bend), atol=1e-12,
    )  # fmt: skip


@pytest.mark.parametrize("compliance", [0.1, 2.0])
def test_a_soft_hinge_leaves_a_stiffness_that_is_positive_between_the_nodes(compliance):
    beam, contact = example_beam()
    short = replace(beam.sheet, free_length_m=4.5e-3, elongation_m=36e-3)
    nodes, count = rule(applied_effects.NODES), applied_effects.NODES
    beam = replace(
        beam, sheet=short, s_m=short.free_length_m * nodes.c, measured_length_m=0.0,
        piece_m=short.free_length_m * nodes.b,
        **{n: np.zeros((len(beam.voltage_V), count)) for n in ("rest", "eibm", "bend")},
        soft=np.ones((len(beam.voltage_V), count)),
    )  # fmt: skip
    p = {"relative_compliance": compliance, "in_the_joint": 1.0}
    soft = effect("elongation_flexibility").beam(beam, contact, p).soft
    assert np.max(soft) > 1.5
    check_softness(applied_effects._field(beam, soft[0]), short.free_length_m)


def test_the_course_of_an_effect_at_the_same_times_is_worked_out_once(monkeypatch):
    clock, one = example_clock(), effect("back_relaxation")
    acting, asked = Acting(one, plausible(one)), []
    whole = type(one).course
    monkeypatch.setattr(type(one), "course", lambda self, *a: asked.append(0) or whole(self, *a))
    first = course(acting, clock)
    np.testing.assert_array_equal(course(acting, clock)[0], first[0])
    assert len(asked) == 1
    course(Acting(one, {**acting.values, "time_constant_s": 2.0}), clock)
    course(acting, replace(clock))
    assert len(asked) == 3


def test_the_rolls_slid_from_where_the_opposite_voltage_held_them():
    beam, contact = example_beam()
    way = slid(beam, contact)
    assert way[1] == 1.0  # at +2 V farther out than at -2 V
    assert way[2] == -1.0
    lean = np.sin(contact.gamma_rad)
    assert way[0] == pytest.approx(lean[0] / np.hypot(lean[0], 0.02))  # approached from below
    assert way[3] == pytest.approx(-lean[3] / np.hypot(lean[3], 0.02))  # from above
    assert way[0] > 0.99 > -0.99 > way[3]
    assert way[6] == 0.0  # free
    only = np.array([0, 1])  # without the opposite voltage: from where 0 V held them
    few = replace(beam, **{n: getattr(beam, n)[only] for n in ("voltage_V", "stated_m", "up")})
    kept = replace(contact, s_hat_m=contact.s_hat_m[only], gamma_rad=contact.gamma_rad[only])
    assert slid(few, kept)[1] == 1.0


def test_sliding_too_little_leaves_friction_as_the_placing_left_it():
    beam, contact = example_beam()
    um = np.array([0.0, 3.0, -5.0, 0.0, 4.0, -5.0, np.nan]) * 1e-6
    way = slid(beam, replace(contact, s_hat_m=0.042 + um))
    placed = way[0]
    assert way[1] == 1.0 > placed  # pushed up, then a little further by +2 V, where it ends
    assert way[2] == pytest.approx(way[1] - 0.8)  # 8 um of the 20 that turn it round
    assert way[5] == -1.0 < way[3]  # pushed down, then further by -2 V
    assert way[4] == pytest.approx(way[5] + 0.9)


def test_friction_takes_from_the_force_of_a_leaning_sheet_that_was_slid_outward():
    """What Held has is N t_hat's share and n_hat's; the moment makes the rest of T."""
    beam, contact = example_beam()
    mu, k = 0.1, 1
    other = effect("roll_friction").beam(beam, contact, values("roll_friction", coefficient=mu))
    way, lean, kept = slid(beam, contact)[k], np.tan(contact.gamma_rad[k]), contact.normal_N[k]
    N = kept / (1.0 - mu * way * np.sign(kept) * lean)
    T = mu * way * abs(N)  # on the sheet, along t_hat
    assert kept == pytest.approx(N - T * lean)
    true = -N * contact.lever[k] - T * contact.offset[k]
    moment = -kept * contact.lever[k] + other.bend[k] * beam.stiffness[k]
    assert moment == pytest.approx(true, rel=1e-12)


def test_friction_may_be_the_same_whatever_the_contact_force():
    beam, contact = example_beam()
    p = values("roll_friction", coefficient=0.1, at_force_mN=1.0)
    other = effect("roll_friction").beam(beam, contact, p)
    k, T = 1, 1e-4 * slid(beam, contact)[1]
    turned = T * (np.tan(contact.gamma_rad[k]) * contact.lever[k] + contact.offset[k])
    moment = (other.bend[k] - beam.bend[k]) * beam.stiffness[k]
    assert moment == pytest.approx(-turned, rel=1e-12)


def test_friction_may_pull_one_way_whatever_slid_before():
    beam, contact = example_beam()
    turned = replace(contact, s_hat_m=0.042 - (contact.s_hat_m - 0.042))
    friction = effect("roll_friction")
    for way in (1.0, -1.0):
        p = values("roll_friction", coefficient=0.1, at_force_mN=1.0, one_way=way)
        moment = (friction.beam(beam, contact, p).bend - beam.bend)[1] * beam.stiffness[1]
        T = 1e-4 * way
        lever = np.tan(contact.gamma_rad[1]) * contact.lever[1] + contact.offset[1]
        assert moment == pytest.approx(-T * lever, rel=1e-12)
        same = friction.beam(beam, turned, p)
        assert np.array_equal(same.bend, friction.beam(beam, contact, p).bend)


def test_friction_in_the_cell_alone_takes_its_share_of_the_force_and_bends_nothing():
    beam, contact = example_beam()
    w = replace(example_weighed(), slid=np.where(np.arange(32) % 2, 1.0, -1.0))
    p = values("roll_friction", coefficient=0.1, force_alone=1.0)
    assert effect("roll_friction").beam(beam, contact, p) is beam
    pulled = -0.1 * np.abs(w.normal_N) * w.slid * np.sin(w.gamma_rad)
    np.testing.assert_allclose(effect("roll_friction").force(w, p), pulled, atol=1e-15)
    always = effect("roll_friction").force(w, {**p, "at_force_mN": 1.0})
    np.testing.assert_allclose(always, -1e-4 * w.slid * np.sin(w.gamma_rad), atol=1e-15)
    one_way = effect("roll_friction").force(w, {**p, "one_way": -1.0})
    np.testing.assert_allclose(one_way, 0.1 * np.abs(w.normal_N) * np.sin(w.gamma_rad), atol=1e-15)
    in_the_beam = values("roll_friction", coefficient=0.1, force_alone=0.0)
    assert not np.any(effect("roll_friction").force(w, in_the_beam))


# --------------------------------------------------------------------------------------- load cell


def test_a_misaligned_cell_measures_the_component_along_its_axis():
    w = example_weighed()
    added = effect("load_cell_misalignment").force(w, {"angle_rad": 0.07})
    assert w.force_N + added == pytest.approx(w.normal_N * np.cos(w.gamma_rad - 0.07), rel=1e-12)
    leaning_forward = w.gamma_rad > 0.1
    assert np.all(np.sign(added[leaning_forward]) == np.sign(w.normal_N[leaning_forward]))


def test_offset_drift_and_meniscus_add_what_they_say():
    w = replace(example_weighed(), session=np.linspace(0.0, 1.0, 32))
    assert effect("force_offset").force(w, {"force_mN": 0.3}) == pytest.approx(3e-4)
    drift = effect("force_drift").force(w, {"force_mN": 0.3, "settles": 0.0})
    assert drift[[0, -1]] == pytest.approx([0.0, 3e-4])
    amid = {"force_mN": 0.3, "settles": 0.0, "tared_at": 0.5}
    assert effect("force_drift").force(w, amid)[[0, -1]] == pytest.approx([-1.5e-4, 1.5e-4])
    soon = effect("force_drift").force(w, {"force_mN": 0.3, "settles": 1.0})
    assert soon == pytest.approx(3e-4 * np.expm1(-3.0 * w.session) / np.expm1(-3.0))
    wet = {"force_mN": 0.3, "dries_s": 0.0}
    pull = effect("surface_tension").force(w, wet)
    assert pull == pytest.approx(3e-4 * np.cos(w.gamma_rad))
    dries = effect("surface_tension").force(w, {**wet, "dries_s": 10.0})
    assert dries == pytest.approx(pull * np.exp(-w.wetted_s / 10.0))
    away = example_weighed(touched=False)
    assert not np.any(effect("surface_tension").force(away, wet))
    assert np.all(effect("force_offset").force(away, {"force_mN": 0.3}) == 3e-4)


def weighed(force_mN: list[float], position_mm: float | list[float] = 20.0) -> LoadCellInput:
    force = np.array(force_mN) * 1e-3
    one = np.ones_like(force)
    return LoadCellInput(
        force_N=force,
        normal_N=force,
        gamma_rad=0.0 * one,
        position_m=1e-3 * np.array(position_mm) * one,
        voltage_V=0.0 * one,
        session=0.5 * one,
        touching=one,
    )


def test_the_cell_hangs_behind_by_half_the_height_of_its_loop():
    p = {"force_mN": 0.05, "from_no_load": 0.0, "reach_mN": 0.0}
    loop = effect("load_cell_hysteresis")
    added = loop.force(weighed([0, 2, 2, 3, -1, -1, 2, 2.5]), p) * 1e3
    assert added == pytest.approx([0, -0.05, -0.05, -0.05, 0.05, 0.05, -0.05, -0.05], abs=1e-6)
    loaded = loop.force(weighed([1, 1, -2]), {**p, "from_no_load": 1.0}) * 1e3
    assert loaded == pytest.approx([-0.05, -0.05, 0.05], abs=1e-6)


def test_a_loop_of_long_reach_turns_over_slowly():
    p = {"force_mN": 0.4, "from_no_load": 0.0, "reach_mN": 4.0}
    added = effect("load_cell_hysteresis").force(weighed([0.0, 1.0, 100.0, 99.0]), p) * 1e3
    wanted = [0.0, -0.4 * -np.expm1(-0.25), -0.4, 0.4 - 0.8 * np.exp(-0.25)]
    assert added == pytest.approx(wanted, abs=1e-9)


def test_small_changes_of_load_move_inside_the_loop():
    p = {"force_mN": 0.05, "from_no_load": 0.0, "reach_mN": 0.0}
    loop = effect("load_cell_hysteresis")
    added = loop.force(weighed([1.0, 1.001, 1.002]), p) * 1e3
    assert added == pytest.approx([0.0, -0.001, -0.002], rel=0.05)  # it does not follow at all
    one, two = (loop.force(weighed([1.0, 1.0 + d]), p)[1] for d in (1e-6, -1e-6))
    assert one == pytest.approx(-two, rel=1e-4)  # no jump between rising and falling


def test_a_cell_that_is_never_relieved_takes_its_history_to_the_next_position():
    """So the readings at 0 V depend on the position before."""
    p = {"force_mN": 0.05, "from_no_load": 2.0, "reach_mN": 0.0}
    loop = effect("load_cell_hysteresis")
    added = loop.force(weighed([2, -1, 0.5, 0.5, -2, 1.0], [5, 5, 5, 10, 10, 15]), p) * 1e3
    assert added == pytest.approx([-0.05, 0.05, -0.05, -0.05, 0.05, -0.05], abs=1e-6)
    anew = loop.force(weighed([2, 0.5], [5, 10]), {**p, "from_no_load": 1.0}) * 1e3
    assert anew == pytest.approx([-0.05, -0.05], rel=1e-3)
    on = loop.force(weighed([2, 0.5], [5, 10]), p) * 1e3
    assert on == pytest.approx([-0.05, 0.05], rel=1e-3)


def test_each_position_begins_a_loop_of_its_own_and_rows_are_runs():
    p = {"force_mN": 0.05, "from_no_load": 0.0, "reach_mN": 0.0}
    loop = effect("load_cell_hysteresis")
    both = loop.force(weighed([0, 2, -1, -1, 2], [5, 5, 5, 10, 10]), p)
    assert both[3] == 0.0
    rows = [[0.0, 2.0, -1.0], [-1.0, 2.0, 1.0]]
    w = LoadCellInput(
        **{
            f: np.stack([getattr(weighed(r), f) for r in rows])
            for f in LoadCellInput.__annotations__
        }
    )
    for row, alone in zip(loop.force(w, p), rows, strict=True):
        assert row == pytest.approx(loop.force(weighed(alone), p))


def test_a_sticking_sheet_keeps_back_a_change_of_force_at_far_positions_only():
    p = {"force_mN": 0.2, "from_position_mm": 20.0, "kind": 0.0}
    forces = [1.0, 1.0, 3.0, -2.0, 3.0]
    stick = effect("roll_sticking")
    assert not np.any(stick.force(weighed(forces, 15.0), p))
    far = stick.force(weighed(forces, 20.0), p) * 1e3
    assert far == pytest.approx([0.0, 0.0, -0.2, 0.2, -0.2], abs=1e-3)


def test_a_sheet_that_is_held_shows_less_of_every_force():
    p = {"force_mN": 0.2, "from_position_mm": 20.0, "kind": 2.0}
    far = effect("roll_sticking").force(weighed([1.0, 3.0, -2.0, 0.0], 25.0), p) * 1e3
    assert far == pytest.approx([-0.2, -0.2, 0.2, 0.0], abs=1e-6)


def test_a_sheet_that_is_pulled_one_way_shows_as_much_more_of_every_force():
    p = {"force_mN": 0.2, "from_position_mm": 20.0, "kind": 3.0}
    far = effect("roll_sticking").force(weighed([1.0, 3.0, -2.0, 0.0], 25.0), p) * 1e3
    assert far == pytest.approx([0.2, 0.2, 0.2, 0.2])


def test_play_between_the_rolls_puts_the_contact_on_the_side_that_is_pressed():
    beam, contact = example_beam()
    contact = replace(contact, normal_N=np.array([1.0, -1.0, 0.0, np.nan, 1.0, -1.0, 1.0]) * 1e-3)
    p = {"offset_mm": 0.4, "at_the_pressed": 1.0}
    moved = effect("roll_offset").beam(beam, contact, p).offset_m - beam.offset_m
    assert moved * 1e3 == pytest.approx([0.4, -0.4, 0.0, 0.0, 0.4, -0.4, 0.4])


@pytest.mark.parametrize(("of", "wanted"), [
    (0.0, lambda R, p, c: (R + c, p / (R + c))),
    (1.0, lambda R, p, c: (R + c, p / R)),
    (2.0, lambda R, p, c: _polar(c + R * np.exp(1j * p / R))),
    (4.0, lambda R, p, c: _polar(c * np.exp(1j * np.pi / 6.0) + R * np.exp(1j * p / R))),
    (8.0, lambda R, p, c: _polar(1j * c + R * np.exp(1j * p / R))),
    (12.0, lambda R, p, c: _polar(c * np.exp(5j * np.pi / 6.0) + R * np.exp(1j * p / R))),
])  # fmt: skip
def test_the_load_cell_moves_on_another_arc(of, wanted):
    beam, contact = example_beam()
    after = effect("arc_error").beam(beam, contact, {"offset_mm": 0.8, "of": of})
    held, R = np.isfinite(beam.stated_m), beam.sheet.arc_radius_m
    radius_m, angle = wanted(R, beam.stated_m[held], 0.8e-3)
    np.testing.assert_allclose((R + after.reach_m)[held], radius_m)
    np.testing.assert_allclose((beam.stated_m + after.shift_m)[held] / R, angle)
    assert np.all(np.isfinite(after.reach_m + after.shift_m))


def _polar(place):
    return np.abs(place), np.angle(place)


def test_a_rest_curvature_may_be_off_in_proportion():
    beam, contact = example_beam()
    stated = (np.array([0.0, 0.05]), np.array([30.0, 10.0]))
    beam = replace(beam, sheet=replace(beam.sheet, initial_curvature=stated))
    p = values("initial_curvature", curvature_error_per_m=2.0)
    assert effect("initial_curvature").beam(beam, contact, p).rest - beam.rest == pytest.approx(2.0)
    like = (
        effect("initial_curvature").beam(beam, contact, {**p, "like_stated": 1.0}).rest - beam.rest
    )
    assert like[0] == pytest.approx(2.0 * np.interp(beam.s_m, *stated) / 20.0, rel=1e-6)


# -------------------------------------------------------------------------------------------- time


def test_a_lag_leaves_what_has_not_been_charged_yet():
    clock, lag = example_pulse(), values("charging_lag", time_constant_s=0.15, remembers=0.0)
    eibm, stiffness = effect("charging_lag").course(clock, lag)
    assert eibm == pytest.approx(-2.0 * np.exp(-clock.pulse_s / 0.15))
    assert not np.any(stiffness)
    eibm, _ = effect("charging_lag").course(example_clock(), lag)
    assert not np.any(eibm[:10])  # at 0 V
    assert eibm[10] == pytest.approx(0.5 * eibm[11])  # the first pulse comes from 0, not from -1


def test_a_lag_stands_behind_the_known_rise_of_the_voltage():
    clock, tau = replace(example_pulse(), rise_s=0.04), 0.15
    t = clock.pulse_s
    lag = values("charging_lag", time_constant_s=tau, remembers=0.0)
    eibm, _ = effect("charging_lag").course(clock, lag)
    two = (tau * np.exp(-t / tau) - 0.04 * np.exp(-t / 0.04)) / (tau - 0.04)  # of two lags in a row
    assert eibm == pytest.approx(-2.0 * (two - np.exp(-t / 0.04)), rel=1e-12)
    same, _ = effect("charging_lag").course(replace(clock, rise_s=tau), lag)
    assert same == pytest.approx(-2.0 * t / tau * np.exp(-t / tau), rel=1e-7)


def test_relaxation_is_counted_from_the_sampling_point():
    p = values("back_relaxation", relative_loss_at_sample=0.1, time_constant_s=0.7)
    relax = effect("back_relaxation")
    clock = replace(example_pulse(), pulse_s=np.array([0, 0.1, 0.5, 0.55, 1e3, 0.2, 0.3, 0.4]))
    eibm, _ = relax.course(clock, p)
    assert eibm[0] == pytest.approx(1.0 / 0.9 - 1.0)  # 10 % of it will be lost
    assert eibm[2] == pytest.approx(0.0, abs=1e-15)
    assert eibm[1] > 0.0 > eibm[3] > eibm[4]
    whole = 0.1 / (1.0 - np.exp(-0.5 / 0.7))
    assert eibm[4] == pytest.approx((1.0 - whole) / 0.9 - 1.0)


def test_the_first_pulses_fall_short():
    p = {"relative_deficit": 0.2, "ratio": 0.5}
    eibm, _ = effect("first_pulse_transient").course(example_clock(), p)
    assert eibm[9:13] == pytest.approx([0.0, -0.2, -0.1, -0.05])
    early = replace(example_pulse(), pulse=np.zeros(8))  # within the first pulse
    eibm, _ = effect("first_pulse_transient").course(early, p)
    assert eibm == pytest.approx(-0.2 * 0.5 ** ((early.pulse_s - 0.5) / 0.6))


def test_creep_is_the_same_in_each_decade():
    clock = replace(example_clock(), run_s=np.geomspace(0.5, 500.0, 32))
    p = values("viscoelastic_creep", relative_change_per_decade=-0.02)
    _, stiffness = effect("viscoelastic_creep").course(clock, p)
    assert stiffness[-1] - stiffness[0] == pytest.approx(-0.06)
    assert np.diff(stiffness) == pytest.approx(-0.06 / 31)


def creep(**own: float) -> dict[str, float]:
    usual = {"relative_change_per_decade": -0.02, "time_s": 8.0, "spread": 1.0, "from_run": 0.0}
    return {**usual, **own}


@pytest.mark.parametrize("from_run", [0.0, 1.0])
def test_a_strain_that_stays_becomes_the_shape_at_rest(from_run):
    beam, contact = example_beam()
    bent = -(contact.normal_N / beam.stiffness)[:, None] * contact.lever  # at 0 V, by the contact
    clock = beam.clock
    held_s = clock.run_s if from_run else clock.wetted_s
    share = 0.02 / (np.exp(-0.25) - np.exp(-2.5)) * -np.expm1(-held_s / 8.0)
    rest = (
        effect("viscoelastic_creep").beam(beam, contact, creep(from_run=from_run)).rest - beam.rest
    )
    for k in (0, 3):
        mean = np.mean(share[beam.reading_of == k])
        np.testing.assert_allclose(rest[k], mean * bent[k], atol=1e-12)
    assert effect("viscoelastic_creep").course(clock, creep()) is None


@pytest.mark.parametrize("left_out_V", [-2.0, 0.0, 2.0])
def test_where_a_voltage_is_left_out_the_voltage_changes_nothing_of_the_strain_that_stays(
    left_out_V,
):
    beam, contact = example_beam()
    use = (beam.voltage_V != left_out_V) & np.isfinite(beam.stated_m)
    of = {
        name: getattr(beam, name)[use]
        for name in ("voltage_V", "stated_m", "stiffness", "eibm", "bend", "soft")
    }
    held = {"normal_N": contact.normal_N[use], "lever": contact.lever[use]}
    at_zero, mean, half = strains(replace(beam, **of), replace(contact, **held))
    np.testing.assert_array_equal(mean, at_zero)
    whole_at_zero, whole_mean, whole_half = strains(beam, contact)
    same = whole_at_zero if left_out_V else whole_mean
    np.testing.assert_array_equal(at_zero, same[use])
    np.testing.assert_array_equal(half, 0.0 if left_out_V else whole_half[use])


def test_what_lags_behind_is_on_the_average_in_the_beam_already():
    beam, contact = example_beam()
    lagging = effect("viscoelastic_creep").lagging(beam, contact, creep(spread=5.0))
    assert len(lagging) == 3
    for _, much in lagging:
        assert np.bincount(beam.reading_of, beam.share * much) == pytest.approx(
            np.zeros(7), abs=1e-12
        )
    assert effect("viscoelastic_creep").lagging(beam, contact, creep(time_s=0.0)) == []


def alternating(seconds: float, step_s: float) -> np.ndarray:
    """Voltages in turn, +1 first, of 0.6 s each."""
    return np.where(np.arange(0.0, seconds, step_s) % 1.2 < 0.6, 1.0, -1.0)


def filtered(drive: np.ndarray, tau_s: float, step_s: float) -> np.ndarray:
    """What a first-order lag makes of it, one more number than `drive`."""
    y = np.zeros(len(drive) + 1)
    for k, d in enumerate(drive):
        y[k + 1] = d + (y[k] - d) * np.exp(-step_s / tau_s)
    return y


def sampled(pulses: int, pulse_s: float) -> AcquisitionTimes:
    """One reading in each of so many pulses."""
    pulse, zero = np.arange(float(pulses)), np.zeros(pulses)
    return AcquisitionTimes(
        voltage_V=np.where(pulse % 2 == 0.0, 2.0, -2.0), pulse_s=zero + pulse_s, pulse=pulse,
        run_s=zero, session=zero, wetted_s=zero, driven_s=0.6 * pulse,
        opposite=np.where(pulse > 0.0, -1.0, 0.0),
    )  # fmt: skip


def test_alternating_pulses_lag_as_a_first_order_filter_says():
    tau, step = 1.3, 1e-4
    clock = sampled(10, 0.5)
    y = filtered(alternating(6.0, step), tau, step)
    wanted = y[np.round((0.6 * clock.pulse + 0.5) / step).astype(int)]
    assert np.sign(clock.voltage_V) * lagging(clock, tau, -1.0) == pytest.approx(wanted, abs=2e-4)


@pytest.mark.parametrize("tau", [0.1, 0.4, 1.5])
def test_a_lag_has_not_forgotten_the_pulse_before(tau: float):
    clock, step = sampled(8, 0.35), 1e-4
    y = filtered(alternating(5.0, step), tau, step)
    wanted = y[np.round((0.6 * clock.pulse + 0.35) / step).astype(int)]
    p = values("charging_lag", time_constant_s=tau)
    eibm, _ = effect("charging_lag").course(clock, p)
    assert np.sign(clock.voltage_V) * (1.0 + eibm) == pytest.approx(wanted, abs=2e-4)
    part, _ = effect("charging_lag").course(clock, {**p, "slow_share": 0.3})
    assert part == pytest.approx(0.3 * eibm)
    anew, _ = effect("charging_lag").course(clock, {**p, "remembers": 0.0})
    assert anew[1:] == pytest.approx(-2.0 * np.exp(-0.35 / tau))


@pytest.mark.parametrize("spread", [1.0, 4.0])
def test_a_relaxation_that_remembers_follows_all_pulses(spread: float):
    late, step, tau = sampled(60, 0.2), 1e-3, 0.7
    drive = alternating(36.0, step)
    slow = np.mean([filtered(drive, t, step) for t in (tau / spread, tau, tau * spread)], axis=0)
    times = tau * np.array([1.0 / spread, 1.0, spread])
    a = 0.1 / np.mean(1.0 - np.exp(-0.5 / times))  # of a sheet at rest 0.1 is lost at 0.5 s
    left = np.append(drive, drive[-1]) - a * slow
    at = {t: np.round((0.6 * late.pulse + t) / step).astype(int) for t in (0.2, 0.5)}
    wanted = np.sign(late.voltage_V) * left[at[0.2]] / abs(left[at[0.5]][-1])
    p = {"relative_loss_at_sample": 0.1, "time_constant_s": tau, "remembers": 1.0}
    eibm, _ = effect("back_relaxation").course(late, {**p, "spread": spread})
    assert 1.0 + eibm == pytest.approx(wanted, abs=2e-3)


def drifting(session: list[float], driven_s: list[float]) -> AcquisitionTimes:
    return replace(example_clock(), session=np.array(session), driven_s=np.array(driven_s))


@pytest.mark.parametrize(("name", "which"), [("eibm_drift", 0), ("stiffness_drift", 1)])
def test_a_drift_changes_by_its_size_over_the_data_or_since_wetting(name: str, which: int):
    clock = drifting([0.0, 0.5, 1.0], [13.2, 6.6, 0.0])
    p = {"relative_change": 0.1, "settles": 0.0}
    over = effect(name).course(clock, {**p, "since_wetting": 0.0})
    since = effect(name).course(clock, {**p, "since_wetting": 1.0})
    assert over[which] == pytest.approx([-0.05, 0.0, 0.05])
    assert since[which] == pytest.approx([0.05, 0.0, -0.05])
    assert not np.any(over[1 - which])


def test_a_drift_that_settles_goes_as_far_but_sooner():
    clock = drifting(np.linspace(0.0, 1.0, 11).tolist(), [0.0] * 11)
    p = {"relative_change": 0.1, "since_wetting": 0.0, "settles": 1.0}
    found, _ = effect("eibm_drift").course(clock, p)
    assert found[[0, -1]] == pytest.approx([-0.05, 0.05])
    assert np.diff(found)[1:] / np.diff(found)[:-1] == pytest.approx(np.exp(-0.3))


def test_a_drift_may_go_faster_and_faster():
    clock = drifting([0.0, 0.5, 1.0], [0.0] * 3)
    p = {"relative_change": 0.1, "since_wetting": 0.0, "settles": -1.0}
    found, _ = effect("eibm_drift").course(clock, p)
    assert found == pytest.approx([-0.05, -0.025, 0.05])


def test_a_drift_between_the_runs_stands_still_during_each():
    clock = drifting([0.3, 0.32, 0.7, 0.72], [0.0] * 4)
    p = {"relative_change": 0.1, "since_wetting": 2.0, "settles": 0.0}
    began = replace(clock, run_began=np.array([0.3, 0.3, 0.7, 0.7]))
    assert effect("stiffness_drift").course(began, p)[1] == pytest.approx(
        [-0.02, -0.02, 0.02, 0.02]
    )
    every = effect("stiffness_drift").course(clock, {**p, "since_wetting": 0.0})[1]
    assert effect("stiffness_drift").course(clock, p)[1] == pytest.approx(every)  # nobody knows
    on = {"goes_on": 1.0}  # through all sessions: when a run began is known in its own
    all_sessions = replace(began, overall=0.5 * clock.session)
    assert effect("stiffness_drift").course(all_sessions, {**p, **on})[1] == pytest.approx(
        0.1 * (0.5 * clock.session - 0.5)
    )


def test_a_drift_between_the_runs_is_none_to_tell_where_the_positions_are_in_order():
    for name in ("eibm_drift", "stiffness_drift"):
        tried = {k.name: k.starting_values for k in effect(name).in_order_of_positions().parameters}
        assert tried["since_wetting"] == (0.0, 1.0)
    assert effect("gravity").in_order_of_positions() == effect("gravity")


def test_drying_is_bounded():
    long = drifting([0.0, 1.0], [0.0, 1e4])
    p = {"relative_change": 1.0, "since_wetting": 1.0, "settles": 0.0}
    assert effect("stiffness_drift").course(long, p)[1][1] == pytest.approx(1.2)
    p["relative_change"] = -1.0
    assert effect("stiffness_drift").course(long, p)[1][1] == pytest.approx(1.0 / 2.2 - 1.0)
    assert effect("eibm_drift").course(long, p)[0][1] == pytest.approx(-0.95)


# ------------------------------------------------------------------------------------------ camera


def test_a_wrong_scale_moves_points_away_from_the_clamp():
    points = example_points()
    for axis, along_x, along_y in ((0.0, 1.0, 1.0), (-1.0, 1.0, 0.0), (1.0, 0.0, 1.0)):
        p = {"relative_error": 0.02, "axis": axis}
        x, y = effect("camera_scale").curve(points, p)
        assert x == pytest.approx(0.02 * along_x * points.x_m)
        assert y == pytest.approx(0.02 * along_y * points.y_m)


def test_a_rolled_camera_turns_pictures_and_no_lengths():
    points = example_points()
    x, y = effect("camera_roll").curve(points, {"angle_rad": 0.3})
    turned = (points.x_m + 1j * points.y_m) * np.exp(0.3j)
    assert points.x_m + x == pytest.approx(turned.real)
    assert points.y_m + y == pytest.approx(turned.imag)


def test_perspective_is_a_scale_that_changes_across_the_picture():
    points = example_points()
    p = {"relative_error": 0.02, "direction_rad": 0.0}
    x, y = effect("camera_perspective").curve(points, p)
    share = 0.02 * points.x_m / 0.05
    assert x == pytest.approx(share * points.x_m)
    assert y == pytest.approx(share * points.y_m)
    x, y = effect("camera_perspective").curve(points, {**p, "direction_rad": np.pi / 2})
    share = 0.02 * points.y_m / 0.05
    assert x == pytest.approx(share * points.x_m, abs=1e-15)
    assert y == pytest.approx(share * points.y_m, abs=1e-15)


@pytest.mark.parametrize("through_zero", [0.0, 1.0])
def test_an_older_picture_shows_what_had_come_by_then(through_zero: float):
    clock = replace(sampled(3, 0.5), rise_s=0.1, opposite=np.array([0.0, -0.7, -0.7]))
    p = {"delay_s": 0.3, "through_zero": through_zero}
    way = 1.0 - np.array([0.0, -1.0, -1.0] if through_zero else clock.opposite)
    then, now = 1.0 - way * np.exp(-2.0), 1.0 - way * np.exp(-5.0)
    assert effect("frame_delay").in_image(clock, p) == pytest.approx(then / now - 1.0)
    late = effect("frame_delay").in_image(clock, {**p, "delay_s": 0.55})  # before the edge
    assert late == pytest.approx((1.0 - way) / now - 1.0)
    assert effect("force_offset").in_image(clock, {"force_mN": 1.0}) is None


def test_the_loop_of_one_run_is_that_of_each_of_several():
    force_N = 1e-3 * np.random.default_rng(3).normal(size=(2, 40))
    position_m = np.broadcast_to(np.repeat([0.0, 0.01], 20), force_N.shape)
    for begins in ({"from_no_load": True}, {"from_no_load": False, "goes_on": True}):
        both = hung(force_N, position_m, 4e-4, **begins)
        each = [hung(f, p, 4e-4, **begins) for f, p in zip(force_N, position_m, strict=True)]
        np.testing.assert_array_equal(both, each)
    assert hung(force_N[0, :0], position_m[0, :0], 4e-4, from_no_load=True).shape == (0,)


@pytest.mark.parametrize("origin_deg", [0.0, 100.0, 170.0, -175.0])
def test_an_arc_whose_centre_is_beside_the_clamp_moves_all_positions_a_little(origin_deg):
    """Beyond half a turn they were moved by a whole one."""
    beam, contact = example_beam()
    turned = replace(beam, sheet=replace(beam.sheet, arc_origin_rad=np.radians(origin_deg)))
    p = values("arc_error", offset_mm=1.0, of=2.0)  # the centre is 1 mm along x
    moved = effect("arc_error").beam(turned, contact, p)
    angle = np.nan_to_num(beam.stated_m) / RADIUS_M + np.radians(origin_deg)
    assert moved.reach_m - beam.reach_m == pytest.approx(1e-3 * np.cos(angle), abs=2e-5)
    assert moved.shift_m - beam.shift_m == pytest.approx(-1e-3 * np.sin(angle), abs=5e-5)
