"""The chain of links against exact solutions."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sim_hardware.world.chain.chain import Chain, ChainSheet, Equilibrium
from sim_hardware.world.chain.contact import ContactArc, ContactState

REFERENCE = Path(__file__).parents[1] / "data" / "reference"
R = 0.04
Floats = np.ndarray


def rows(name: str) -> list[dict[str, str]]:
    with (REFERENCE / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def constant(value: float) -> Callable[[Floats], Floats]:
    return lambda s: np.full_like(s, value)


def varying(row: dict[str, str]) -> Callable[[Floats], Floats]:
    a, decay = float(row["A_1_per_mm"]) * 1e3, float(row["lambda_mm"]) * 1e-3
    k0, k1 = float(row["k0_1_per_mm"]) * 1e3, float(row["k1_1_per_mm2"]) * 1e6
    return lambda s: a * np.exp(-s / decay) + k0 + k1 * s


def held(sheet: ChainSheet, row: dict[str, str], link_m: float) -> Equilibrium:
    contact = ContactState(Chain(sheet, link_m), ContactArc(radius_m=R))
    state = contact.place(0.0, float(row["p_mm"]) * 1e-3 / R)
    assert state is not None
    return state


def errors(sheet: ChainSheet, row: dict[str, str], link_m: float) -> Floats:
    """Of N and F (relative to B/R^2 or, if larger, themselves), s_hat/R and phi_hat."""
    state = held(sheet, row, link_m)
    N, F = float(row["N_R2_over_B"]), float(row["F_R2_over_B"])
    return np.array(
        [
            (state.normal_per_m2 * R**2 - N) / max(1.0, abs(N)),
            (state.along_per_m2 * R**2 - F) / max(1.0, abs(F)),
            state.s_m / R - float(row["shat_mm"]) * 1e-3 / R,
            state.angle_rad - float(row["phihat_rad"]),
        ]
    )


CONSTANT = rows("iv_v_vi_contact_constant_kappa_R40mm.csv")
VARYING = rows("v_varying_kappa_contact_R40mm.csv")


def sheet_of(row: dict[str, str]) -> ChainSheet:
    length_m = float(row["l_mm"]) * 1e-3
    if "A_1_per_mm" in row:
        return ChainSheet(
            free_length_m=length_m, elongation_m=0.06, rest_curvature_per_m=varying(row)
        )
    return ChainSheet(
        free_length_m=length_m,
        elongation_m=0.06,
        rest_curvature_per_m=constant(float(row["kappa_star_1_per_mm"]) * 1e3),
    )


@pytest.mark.parametrize("row", CONSTANT + VARYING)
def test_the_held_chain_approaches_the_exact_solution_with_the_square_of_the_link_length(
    row: dict[str, str],
) -> None:
    coarse, fine = (errors(sheet_of(row), row, link) for link in (0.25e-3, 0.125e-3))
    # Angles up to 2 rad over 400 links: (kappa h)^2 / 24 and its like, times a few.
    assert np.all(np.abs(fine) < 2e-5), fine
    # Where the error is not about to change its sign it falls by four; that of the angle ripples
    # a little as the contact passes from link to link.
    clear = np.abs(coarse) > 2e-6
    off = np.abs(fine[clear] / coarse[clear] - 0.25)
    assert np.all(off < np.array([0.01, 0.01, 0.01, 0.04])[clear]), (coarse, fine)


def test_the_order_of_convergence_is_two() -> None:
    row = next(r for r in VARYING if r["p_mm"] == "40")
    links = 1e-3 / 2.0 ** np.arange(5)
    found = np.array([np.abs(errors(sheet_of(row), row, link)) for link in links])
    orders = np.log2(found[:-1, :3] / found[1:, :3])  # N, F and s_hat; the angle ripples
    assert np.all(np.abs(orders - 2) < 0.05), orders
    assert np.all(found[:, 3] < 2e-5 * (links / 1e-3) ** 2)


@pytest.mark.parametrize("row", rows("iii_v_constant_curvature_arcs_R40mm.csv"))
def test_the_free_chain_is_an_arc_and_crosses_where_it_should(row: dict[str, str]) -> None:
    k = float(row["kappa_1_per_mm(k0+Me/B)"]) * 1e3
    length_m = float(row["l_mm"]) * 1e-3
    link_m = 0.1e-3
    contact = ContactState(
        Chain(
            ChainSheet(free_length_m=length_m, elongation_m=0.06, rest_curvature_per_m=constant(k)),
            link_m,
        ),
        ContactArc(radius_m=R),
    )
    # The corners of a chain lie on a circle that is larger by (k h)^2 / 12 or / 24 of itself, and
    # the contact is rounded over links, which moves it by about k h^2 / 6.
    near_mm = 50 * (k * link_m) ** 2 / 4 + 1e3 * abs(k) * link_m**2 / 4 + 1e-9
    free = contact.chain.free(0.0)
    tip_mm = contact.chain.curve(free.phi_rad, np.array([length_m]))[0] * 1e3
    assert tip_mm == pytest.approx([float(row["x_l_mm"]), float(row["y_l_mm"])], abs=near_mm)
    crossing = contact.free_crossing(free)
    assert crossing is not None
    assert crossing.s_m * 1e3 == pytest.approx(float(row["shat_free_mm"]), abs=near_mm)
    assert contact.polar_angle_rad(crossing) * R * 1e3 == pytest.approx(
        float(row["p_free_mm"]), abs=near_mm
    )


@pytest.mark.parametrize("row", rows("i_mattiasson_dead_tip_load.csv")[:5])
def test_an_evenly_spread_weight_bends_less_than_the_same_weight_at_the_tip(
    row: dict[str, str],
) -> None:
    length_m, load = 0.05, float(row["FL2_over_EI"])
    per_length = load / length_m**3
    chain = Chain(ChainSheet(free_length_m=length_m, load_per_m3=(0.0, per_length)), 0.1e-3)
    tip = chain.curve(chain.free(0.0).phi_rad, np.array([length_m]))[0]
    assert 0 < tip[1] < float(row["w_over_L(deflection)"]) * length_m


def test_a_small_even_load_bends_the_chain_as_the_linear_beam() -> None:
    length_m, per_length = 0.05, 1e-3 / 0.05**3
    chain = Chain(ChainSheet(free_length_m=length_m, load_per_m3=(0.0, per_length)), 0.1e-3)
    tip = chain.curve(chain.free(0.0).phi_rad, np.array([length_m]))[0]
    assert tip[1] == pytest.approx(per_length * length_m**4 / 8, rel=1e-4)


LONG = ChainSheet(
    free_length_m=0.05,
    rest_curvature_per_m=lambda s: 24 * np.exp(-s / 0.04),
    drive_curvature_per_m=lambda s: 100 * np.exp(-s / 0.012),
)
MIRRORED = ChainSheet(
    free_length_m=0.05,
    rest_curvature_per_m=lambda s: -24 * np.exp(-s / 0.04),
    drive_curvature_per_m=lambda s: 100 * np.exp(-s / 0.012),
)


def test_the_mirrored_sheet_does_the_mirrored_thing() -> None:
    for position_m, drive in ((0.0, 1.0), (0.012, -0.5), (0.03, 0.0)):
        states = []
        for sheet, sign in ((LONG, 1), (MIRRORED, -1)):
            contact = ContactState(Chain(sheet, 0.2e-3), ContactArc(radius_m=R))
            start = contact.place(0.0, sign * position_m / R)
            assert start is not None
            state, whole = contact.drive_to(start, sign * drive, sign * position_m / R)
            assert whole
            states.append(state)
        one, other = states
        assert one.along_per_m2 == pytest.approx(-other.along_per_m2, rel=1e-9)
        assert one.outward_per_m2 == pytest.approx(other.outward_per_m2, rel=1e-9)
        assert one.s_m == pytest.approx(other.s_m, rel=1e-12)
        assert one.phi_rad == pytest.approx(-other.phi_rad, abs=1e-12)


def test_the_force_along_the_arc_is_the_energy_s_derivative() -> None:
    contact = ContactState(Chain(LONG, 0.1e-3), ContactArc(radius_m=R))
    start = contact.place(0.0, 0.0)
    assert start is not None
    start, _ = contact.drive_to(start, 0.7, 0.0)
    angles = np.linspace(0.0, 0.75, 61)
    states = [start]
    for angle in angles[1:]:
        state = contact.push_to(states[-1], float(angle))
        assert state is not None
        states.append(state)
    gained = contact.chain.energy_per_m(states[-1]) - contact.chain.energy_per_m(states[0])
    forces = np.array([s.along_per_m2 for s in states])
    done = float(np.sum((forces[1:] + forces[:-1]) / 2 * np.diff(angles))) * R
    # What the sheet does on the object, it loses; the trapezia are good to a few 1e-5.
    assert -gained == pytest.approx(done, rel=1e-4)
    middle = 30
    slope = contact.chain.energy_per_m(states[middle + 1]) - contact.chain.energy_per_m(
        states[middle - 1]
    )
    slope /= (angles[middle + 1] - angles[middle - 1]) * R
    assert -slope == pytest.approx(states[middle].along_per_m2, rel=1e-3)


def test_no_nearby_shape_through_the_same_contact_has_less_energy() -> None:
    contact = ContactState(Chain(LONG, 0.5e-3), ContactArc(radius_m=R))
    state = contact.place(0.0, 0.3)
    assert state is not None
    rng = np.random.default_rng(1)
    least = contact.chain.energy_per_m(state)
    drive = rng.normal(0.0, 1.0, (20, contact.chain.links))
    for bend in drive:
        nudged = ChainSheet(
            free_length_m=0.05,
            rest_curvature_per_m=lambda s, bend=bend: (
                24 * np.exp(-s / 0.04) + np.interp(s, np.linspace(0, 0.05, bend.size), bend)
            ),
            drive_curvature_per_m=LONG.drive_curvature_per_m,
        )
        other = ContactState(Chain(nudged, 0.5e-3), ContactArc(radius_m=R)).place(0.0, 0.3)
        assert other is not None
        moved = Equilibrium(
            drive=0.0,
            phi_rad=other.phi_rad,
            s_m=other.s_m,
            angle_rad=other.angle_rad,
            normal_per_m2=0.0,
            along_per_m2=0.0,
            outward_per_m2=0.0,
        )
        assert contact.chain.energy_per_m(moved) > least


def test_a_position_beyond_the_sheet_s_reach_is_not_reachable() -> None:
    straight = ContactState(Chain(ChainSheet(free_length_m=0.05), 0.2e-3), ContactArc(radius_m=R))
    assert straight.place(0.0, 54.0e-3 / R) is not None
    assert straight.place(0.0, 54.3e-3 / R) is None


def test_a_sheet_too_curled_to_meet_the_arc_cannot_be_placed() -> None:
    curled = ContactState(
        Chain(ChainSheet(free_length_m=0.05, rest_curvature_per_m=constant(100.0)), 0.2e-3),
        ContactArc(radius_m=R),
    )
    assert curled.place(0.0, 0.0) is None


def test_the_clamp_turns_by_its_compliance_times_the_moment_of_the_load() -> None:
    compliance_m = 2e-3
    chain = Chain(ChainSheet(free_length_m=0.05, clamp_compliance_m=compliance_m), 0.1e-3)
    contact = ContactState(chain, ContactArc(radius_m=R))
    state = contact.place(0.0, 0.4)
    assert state is not None
    x, y = R * math.cos(0.4), R * math.sin(0.4)
    ut, un = (-math.sin(0.4), math.cos(0.4)), (math.cos(0.4), math.sin(0.4))
    fx = -(state.along_per_m2 * ut[0] + state.outward_per_m2 * un[0])
    fy = -(state.along_per_m2 * ut[1] + state.outward_per_m2 * un[1])
    assert state.phi_rad[0] == pytest.approx(compliance_m * (x * fy - y * fx), rel=1e-3)


def test_friction_turns_the_force_by_its_angle() -> None:
    for mu in (0.1, -0.2):
        contact = ContactState(
            Chain(ChainSheet(free_length_m=0.05), 0.1e-3), ContactArc(radius_m=R, friction=mu)
        )
        state = contact.place(0.0, 0.4)
        assert state is not None
        radial, along = state.outward_per_m2, state.along_per_m2
        tangential = along * math.sin(state.angle_rad - 0.4) + radial * math.cos(
            state.angle_rad - 0.4
        )
        assert tangential / state.normal_per_m2 == pytest.approx(-mu, rel=1e-4)


def test_rolls_beside_the_neutral_curve_touch_it_further_on() -> None:
    offset_m = 1e-3
    contact = ContactState(
        Chain(ChainSheet(free_length_m=0.05), 0.1e-3),
        ContactArc(radius_m=R, roll_offset_m=offset_m),
    )
    state = contact.place(0.0, 0.4)
    assert state is not None
    point = contact.chain.curve(state.phi_rad, np.array([state.s_m]))[0]
    normal = np.array([-math.sin(state.angle_rad), math.cos(state.angle_rad)])
    at = point + offset_m * normal
    assert at == pytest.approx([R * math.cos(0.4), R * math.sin(0.4)], abs=1e-7)


@pytest.mark.slow
def test_three_equations_are_solved_whatever_the_order_of_their_rows():
    from sim_hardware.world.chain.contact_kernels import solve_three

    random = np.random.default_rng(0)
    low, step = np.empty((3, 4)), np.empty(3)
    for k in range(200):
        m, right = random.standard_normal((3, 3)), random.standard_normal(3)
        m[k % 3, k % 3] = 0.0
        determinant = solve_three(m, right, low, step)
        assert determinant == pytest.approx(np.linalg.det(m), rel=1e-9)
        np.testing.assert_allclose(step, np.linalg.solve(m, right), rtol=1e-8)
    assert solve_three(np.outer([0.0, 1.0, 2.0], [1.0, 2.0, 4.0]), np.ones(3), low, step) == 0.0
