"""Published models against exact limits, closed-form steps and their contract."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.dynamics.models import DrivenSheet, Response, model, models, origins
from model.dynamics.models.conformance import SHEET, example_run, faults
from model.dynamics.models.gonzalez import chord_m
from model.dynamics.models.held_drive import held_states, lag
from model.dynamics.models.small_deflection import small_deflection
from model.measurements import ModelError
from model.mechanics.equilibrium import problems, solve
from model.mechanics.field import Field

STRAIGHT = replace(SHEET, initial_curvature=None)
L, R = SHEET.free_length_m, SHEET.arc_radius_m


def run(position_m=None, volts=1.0, seconds=1.0, rate=1000, sheet=STRAIGHT, frames=()):
    time = np.arange(int(seconds * rate) + 1) / rate
    return DrivenSheet(
        sheet=sheet, position_m=position_m, time_s=time, drive_V=np.full(len(time), volts),
        frames=np.array(frames, dtype=np.int64),
    )  # fmt: skip


def simulated(name, at, **changed):
    found = model(name)
    return found.simulate(found.start() | changed, at)


@pytest.mark.parametrize("name", models())
def test_a_model_conforms(name):
    assert faults(model(name)) == []
    assert model(name).name == name


def test_there_are_nine_models_and_an_unknown_one_is_named():
    assert len(models()) == 9
    assert origins() == {}
    with pytest.raises(ModelError, match=r"no dynamic model 'leee'.*mean 'lee'\?"):
        model("leee")


def test_a_name_without_its_source_is_a_fault():
    bad = replace(model("lee"), title="Lee, Park and Kim 2005")
    assert "must begin with 'after'" in faults(bad)[0]


def test_a_model_that_does_not_return_what_it_says_is_a_fault():
    bad = replace(model("lee"), predicts_free=frozenset({"tip"}))
    assert "it returns ['curve', 'tip']" in faults(bad)[0]


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"time_s": np.zeros(3)}, "must ascend"),
        ({"drive_V": np.zeros(2)}, "as many voltages as times"),
        ({"drive_V": np.array([0.0, np.nan, 0.0])}, "finite"),
        ({"frames": np.array([3])}, "does not have"),
        ({"position_m": np.nan}, "position"),
    ],
)
def test_a_bad_drive_is_refused(changed, sentence):
    good = {
        "sheet": SHEET, "position_m": None, "time_s": np.arange(3.0), "drive_V": np.zeros(3)
    }  # fmt: skip
    with pytest.raises(ModelError, match=sentence):
        DrivenSheet(**(good | changed))


@pytest.mark.parametrize("name", ["bao", "huynh_alici", "lee", "newbury_leo", "tamagawa", "yim"])
def test_a_contact_out_of_reach_is_refused(name):
    with pytest.raises(ModelError, match="reach"):
        simulated(name, run(0.0, sheet=replace(STRAIGHT, free_length_m=0.03)))


def test_held_voltages_are_exact_with_even_and_uneven_samples():
    A, B = np.array([[-3.0, 1.0], [0.0, -7.0]]), np.array([0.0, 2.0])
    even = np.linspace(0.0, 1.0, 101)
    uneven = np.sort(np.append(even, [0.0031, 0.517]))
    exact = 2.0 / 21.0 - 2.0 / 12.0 * np.exp(-3.0 * even) + 2.0 / 28.0 * np.exp(-7.0 * even)
    found = held_states(A, B, even, np.ones(101))
    np.testing.assert_allclose(found[:, 0], exact, atol=1e-13)
    again = held_states(A, B, uneven, np.ones(103))[np.isin(uneven, even)]
    np.testing.assert_allclose(again, found, atol=1e-12)
    pole = np.array([[-3.0, 1.0], [0.0, -3.0]])  # no two eigenvectors
    twice = held_states(pole, np.array([0.0, 1.0]), even, np.ones(101))[:, 0]
    np.testing.assert_allclose(twice, (1 - (1 + 3 * even) * np.exp(-3 * even)) / 9, atol=1e-12)


def test_rest_bent_and_loaded_heights_of_the_linear_beam_meet_the_contact():
    at = run(0.006, sheet=SHEET)
    beam = small_deflection(at)
    kappa = np.array([0.0, 10.0, -25.0])
    heights = beam.heights_m(np.array([R]), kappa)[:, 0]
    np.testing.assert_allclose(heights, 0.006, rtol=1e-12)
    # k0 = 5 - 60 s: y(R) = 5 R^2/2 - 60 R^3/6
    rest = 2.5 * R**2 - 10.0 * R**3
    assert beam.off_at_rest_m == pytest.approx(rest - 0.006, rel=1e-12)


def test_the_elongation_touches_where_the_straight_end_goes():
    sheet = replace(STRAIGHT, free_length_m=0.0045, elongation_m=0.04)
    beam = small_deflection(run(0.0, sheet=sheet))
    assert beam.bent_m2 == pytest.approx(0.0045 * (R - 0.0045 / 2.0), rel=1e-12)
    lever = R - np.linspace(0.0, 0.0045, 20001)
    assert beam.compliance_m3 == pytest.approx(np.trapezoid(lever**2, dx=0.0045 / 2e4), rel=1e-8)


def test_lee_is_the_bimorph_after_a_long_time_and_one_lag_before():
    sheet = replace(STRAIGHT, arc_radius_m=L)  # the contact is the tip
    w, d = sheet.width_m, sheet.thickness_m
    p = model("lee").start()
    tip = 3.0 * p["d31_m_per_V"] * L**2 / (2.0 * d**2)
    blocked = 3.0 * w * d * p["E_Pa"] * p["d31_m_per_V"] / (8.0 * L)
    at = run(None, seconds=3.0, sheet=sheet)
    charged = 1.0 - np.exp(-at.time_s / p["charging_s"])
    np.testing.assert_allclose(simulated("lee", at).tip_m, tip * charged, atol=1e-12)
    held = simulated("lee", replace(at, position_m=0.0)).force_N
    np.testing.assert_allclose(held, blocked * charged, atol=1e-12)


@pytest.mark.parametrize("name", ["bao", "huynh_alici", "lee", "newbury_leo", "tamagawa", "yim"])
def test_force_and_current_follow_the_sign_of_the_voltage(name):
    plus, minus = (simulated(name, run(0.0, volts=v)) for v in (0.3, -0.3))
    assert plus.force_N[-1] > 0.0
    np.testing.assert_allclose(minus.force_N, -plus.force_N, atol=1e-9 * max(plus.force_N))
    if plus.current_A is not None:
        assert plus.current_A[0] > 0.0
        np.testing.assert_allclose(minus.current_A, -plus.current_A, atol=1e-12)


@pytest.mark.parametrize("name", ["bao", "huynh_alici", "lee", "newbury_leo", "tamagawa", "yim"])
def test_a_load_cell_at_the_place_that_the_free_sheet_reaches_feels_nothing(name):
    """Small deflection: the force vanishes where the unloaded sheet would be."""
    found = model(name)
    long, small = found.start(), {}
    for one in found.parameters:  # no back relaxation, no difference of stiffnesses
        small[one.name] = 0.0 if one.name == "m2_Nm_per_V" else long[one.name]
    at = run(0.0, volts=1e-3, seconds=20.0, rate=50)
    bend = {
        "bao": 1e-3 * long.get("K2_per_Cm", 0.0) * long.get("C_F", 0.0),
        "huynh_alici": 1e-3 * long.get("gain_Nm_per_V", 0.0) / long.get("B_Nm2", 1.0),
        "lee": 3e-3 * long.get("d31_m_per_V", 0.0) / SHEET.thickness_m**2,
        "newbury_leo": 3e-3 * long.get("d_m_per_V", 0.0) / SHEET.thickness_m**2,
        "tamagawa": 1e-3 * long.get("m1_Nm_per_V", 0.0) / long.get("B1_Nm2", 1.0),
        "yim": 1e-3 * long.get("km_Nm_per_C", 0) * long.get("C_F", 0) / long.get("B_Nm2", 1.0),
    }[name]
    blocked = found.simulate(small, at).force_N[-1]
    there = found.simulate(small, replace(at, position_m=0.5 * bend * R**2)).force_N[-1]
    assert abs(there) < 5e-3 * blocked


def test_tamagawa_has_its_closed_form_for_a_step():
    p = model("tamagawa").start() | {"B0_Nm2": 2e-6}
    at = run(None, seconds=2.0, frames=[0, 2000])
    t = at.time_s
    B = p["B1_Nm2"] + (p["B0_Nm2"] - p["B1_Nm2"]) * np.exp(-t / p["tB_s"])
    first = p["m1_Nm_per_V"] * (1.0 - np.exp(-t / p["t1_s"]))
    k = (first - p["m2_Nm_per_V"] * (1.0 - np.exp(-t / p["t2_s"]))) / B
    found = simulated("tamagawa", at, B0_Nm2=2e-6)
    np.testing.assert_allclose(found.tip_m[1:], (1 - np.cos(k[1:] * L)) / k[1:], rtol=1e-9)
    np.testing.assert_allclose(found.curves_m[0][1, -1], np.sin(k[-1] * L) / k[-1], rtol=1e-9)


def test_an_arc_that_already_passes_through_the_load_cell_does_not_press():
    arc = replace(STRAIGHT, initial_curvature=(np.array([0.0, L]), np.array([15.0, 15.0])))
    position = R * np.arcsin(15.0 * R / 2.0)
    for sheet in (arc, replace(arc, free_length_m=0.02, elongation_m=0.05)):
        if sheet is not arc:  # the straight elongation's place is found by hand
            x, y = np.sin(0.3) / 15.0, (1 - np.cos(0.3)) / 15.0
            b = x * np.cos(0.3) + y * np.sin(0.3)
            d = -b + np.sqrt(b**2 + R**2 - x**2 - y**2)
            position = R * np.arctan2(y + d * np.sin(0.3), x + d * np.cos(0.3))
        force = simulated("tamagawa", run(position, volts=0.0, sheet=sheet)).force_N
        np.testing.assert_allclose(force, 0.0, atol=1e-12)


def test_bao_has_the_closed_form_of_its_two_states():
    p = model("bao").start() | {"K1_per_Cm": 5e3, "K2_per_Cm": 1e3}
    at = run(None, seconds=5.0)
    t, rc, tau = at.time_s, p["R1_ohm"] * p["C_F"], p["tau_s"]
    found = simulated("bao", at, K1_per_Cm=5e3, K2_per_Cm=1e3)
    current = np.exp(-t / rc) / p["R1_ohm"] + 1.0 / p["R2_ohm"]
    np.testing.assert_allclose(found.current_A, current, rtol=1e-9)
    C, slow, fast = p["C_F"], np.exp(-t / tau), np.exp(-t / rc)
    k = C * (1e3 * (1 - slow) + (5e3 / rc - 1e3 / tau) * (slow - fast) / (1 / rc - 1 / tau))
    np.testing.assert_allclose(found.tip_m[1:], (1 - np.cos(k[1:] * L)) / k[1:], rtol=1e-7)


def test_newbury_leo_is_a_bimorph_at_dc_and_rings_at_its_port_s_frequency():
    p = model("newbury_leo").start()
    kappa = 3.0 * p["d_m_per_V"] / SHEET.thickness_m**2
    at = run(None, seconds=20.0, rate=200)
    free = simulated("newbury_leo", at, ghm_share=1.0, ghm_rad_per_s=30.0)
    assert free.tip_m[-1] == pytest.approx(kappa * L**2 / 2.0, rel=1e-4)
    assert free.current_A[-1] == pytest.approx(1.0 / p["Rdc_ohm"], rel=1e-4)
    held = simulated("newbury_leo", replace(at, position_m=0.0))
    blocked = p["B_Nm2"] * kappa * (R**2 / 2.0) / (R**3 / 3.0)
    assert held.force_N[-1] == pytest.approx(blocked, rel=1e-9)
    # a fast source, hardly any loss: f = sqrt(K/M)/2 pi
    fast = run(None, seconds=1.0, rate=2000)
    tip = simulated("newbury_leo", fast, R_ohm=0.1, C_F=1e-4, ghm_share=1e-3, d_m_per_V=1e-8).tip_m
    moving = np.diff(np.sign(tip - kappa / 50 * L**2 / 2.0))
    crossings = fast.time_s[np.flatnonzero(moving)]
    mass = 33.0 / 140.0 * p["mu_kg_per_m"] * L
    wanted = np.sqrt(3.0 * p["B_Nm2"] / L**3 / mass) / (2.0 * np.pi)
    assert 0.5 / np.mean(np.diff(crossings)) == pytest.approx(wanted, rel=5e-3)


def test_newbury_leo_senses_with_the_coefficient_with_which_it_acts():
    """A clamped port takes s^2 K more capacitance: C + s times the blocked force per volt."""
    sheet = replace(STRAIGHT, arc_radius_m=L)
    p = {"C_F": 1e-4, "d_m_per_V": 1e-5, "R_ohm": 100.0, "Rdc_ohm": 1e7}
    held = simulated("newbury_leo", run(0.0, seconds=20.0, sheet=sheet), **p)
    s = 3.0 * p["d_m_per_V"] * L**2 / (2.0 * SHEET.thickness_m**2)
    i = held.current_A - 1e-7
    charge = 1e-3 * (np.sum(i) - 0.5 * i[0])
    assert charge == pytest.approx(p["C_F"] + s * held.force_N[-1], rel=1e-4)
    assert s * held.force_N[-1] > 0.1 * p["C_F"]


def test_yagasaki_rings_at_the_beam_s_frequency_and_rests_on_a_parabola():
    D, bend = 2e-4, 30.0
    fast = run(None, seconds=4.0, rate=2000)  # charged so slowly that the first mode rings alone
    found = simulated("yagasaki", fast, charging_s=0.1, share=1e-3, relaxation_s=1e-4)
    rest = bend * L**2 / 2.0
    crossings = fast.time_s[np.flatnonzero(np.diff(np.sign(found.tip_m - rest)))]
    wanted = 1.8751040687**2 * np.sqrt(D) / L**2 / (2.0 * np.pi)
    assert 0.5 / np.mean(np.diff(crossings[-9:])) == pytest.approx(wanted, rel=1e-3)
    slow = run(None, seconds=200.0, rate=20, frames=[4000])
    ended = simulated("yagasaki", slow, share=1.0, relaxation_s=0.05)
    x, y = ended.curves_m
    np.testing.assert_allclose(y[0], bend * x[0] ** 2 / 2.0, atol=1e-9)


def test_pugal_s_line_bends_to_an_arc_that_depends_on_polarity():
    at = run(None, seconds=20.0, rate=20, frames=[400])
    found = simulated("pugal", at, r_ohm_per_m=1e-3, g_p_S_per_m=1e-6, b_per_V2m=2.0)
    x, y = found.curves_m
    k = 32.0
    np.testing.assert_allclose([x[0, -1], y[0, -1]],
        [np.sin(k * L) / k, (1 - np.cos(k * L)) / k], rtol=1e-5)  # fmt: skip
    assert found.tip_m[-1] == pytest.approx(y[0, -1])
    assert abs(found.current_A[-1]) < 1e-6
    minus = simulated(
        "pugal", replace(at, drive_V=-at.drive_V), r_ohm_per_m=1e-3, g_p_S_per_m=1e-6,
        b_per_V2m=2.0,
    )  # fmt: skip
    k = -28.0
    assert minus.tip_m[-1] == pytest.approx((1 - np.cos(k * L)) / k, rel=1e-5)


def test_gonzalez_is_the_exact_static_sheet_and_does_not_know_of_voltage():
    found = simulated("gonzalez", run(0.012, sheet=SHEET, volts=2.0), bend_per_m=3.0)
    field = Field.linear(np.array([0.0, L]), np.array([8.0, 5.0]), L)
    exact = solve(problems(field, 0.012 / R, R)).force(1e-6)[0]
    np.testing.assert_allclose(found.force_N, exact, rtol=1e-9)


@pytest.mark.slow
def test_an_axially_loaded_strip_has_the_stiffness_of_an_arc():
    """Small loads: d(chord)/d(P/B) = int y^2 ds over the arc."""
    k0, load = 20.0, 1.0
    s = np.linspace(-L / 2.0, L / 2.0, 20001)
    y = (np.cos(k0 * s) - np.cos(k0 * L / 2.0)) / k0
    slope = (chord_m(load, k0, L) - chord_m(-load, k0, L)) / (2.0 * load)
    assert slope == pytest.approx(np.trapezoid(y**2, s), rel=1e-5)
    assert chord_m(0.0, k0, L) == pytest.approx(2.0 * np.sin(k0 * L / 2.0) / k0, rel=1e-9)


def test_yim_s_links_come_to_the_exact_arc_and_blocked_force():
    p = model("yim").start()
    kappa = p["km_Nm_per_C"] * p["C_F"] / p["B_Nm2"]
    held = simulated("yim", run(0.01, seconds=2.0, rate=50))
    exact = solve(problems(Field.constant(kappa, L), 0.01 / R, R)).force(p["B_Nm2"])[0]
    assert held.force_N[-1] == pytest.approx(exact, rel=2e-2)
    free = simulated("yim", run(None, seconds=4.0, rate=50, frames=[200]), eta_s=0.02)
    assert free.tip_m[-1] == pytest.approx((1 - np.cos(kappa * L)) / kappa, rel=3e-3)


def test_yim_s_free_chain_has_the_beam_s_frequency():
    B, mu = 1e-6, 5e-3
    at = run(None, seconds=1.5, volts=0.02)
    tip = simulated(
        "yim", at, R_ohm=0.1, C_F=0.01, B_Nm2=B, mu_kg_per_m=mu, eta_s=1e-6, drag_Ns2_per_m3=1e-5
    ).tip_m
    middle = 0.02 * 3e-5 / B * L**2 / 2.0
    crossings = at.time_s[np.flatnonzero(np.diff(np.sign(tip - middle)))]
    wanted = 1.8751040687**2 * np.sqrt(B / mu) / L**2 / (2.0 * np.pi)
    count = len(crossings) - (len(crossings) + 1) % 2  # whole periods
    found = (count - 1) / 2.0 / (crossings[count - 1] - crossings[0])
    assert found == pytest.approx(wanted, rel=2e-2)


def test_drag_and_dampers_take_energy():
    def swing(**loss):
        tip = simulated("yim", run(None, seconds=1.5), **({"R_ohm": 1.0} | loss)).tip_m
        return np.ptp(tip[-500:])

    little = swing(eta_s=1e-6, drag_Ns2_per_m3=1e-5)
    assert swing(eta_s=5e-3, drag_Ns2_per_m3=1e-5) < 0.8 * little
    assert swing(eta_s=1e-6, drag_Ns2_per_m3=0.1) < 0.8 * little


def test_a_model_of_another_kind_is_left_out():
    assert "of type int" in faults(3)[0]
    assert isinstance(model("lee").simulate(model("lee").start(), example_run(None)), Response)
    assert lag(1.0, np.array([0.0, 1.0]), np.ones(2))[1] == pytest.approx(1.0 - np.exp(-1.0))
