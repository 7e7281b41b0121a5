"""The world of Legendre series: exact solutions, its noise, and the fit of what it measures.

That world is sealed. Nothing here names what it hides beyond the catalogue.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from benchmarks.worlds.contract import LOCATIONS, Design
from benchmarks.worlds.generators._legendre_noise import STEP_N, WALK_N, RunNoise
from benchmarks.worlds.generators._legendre_ritz import FORCE, GRID, PLACE, Cases, Ritz, Strip
from benchmarks.worlds.generators._legendre_shape import felt, free, held, lies
from benchmarks.worlds.generators._legendre_specimen import specimens
from benchmarks.worlds.generators.legendre import WORLD
from benchmarks.worlds.session.layout import Run
from model import fit
from model.measurements import FloatArray

pytestmark = pytest.mark.thorough

REFERENCE = Path(__file__).parents[1] / "data" / "reference"
R, B = 40e-3, 1.27e-6
FEW = Design(positions_m={"long": (0.0, 0.025), "short": (0.0, 0.025)}, readings=2)


def rows(name: str) -> list[dict[str, float]]:
    with (REFERENCE / name).open(encoding="utf-8") as file:
        return [
            {k: float(v) for k, v in row.items() if k not in {"case", "taylor_residual"}}
            for row in csv.DictReader(file)
        ]


def ritz(length_m: float, rest=None, **more: object) -> Ritz:  # type: ignore[no-untyped-def]
    s, ones = np.linspace(0.0, length_m, GRID), np.ones(GRID)
    given = {
        "s_m": s, "rest_per_m": 0.0 * s if rest is None else rest(s), "driven_per_m": ones,
        "even_per_m": 0.0 * s, "soft": ones, "stiffness_Nm2": B, "radius_m": R,
        "elongation_m": 0.0 if length_m > R else 60e-3,
    }  # fmt: skip
    return Ritz(Strip(**{**given, **more}))


def cases(position_m: list[float], kappa_per_m: list[float], way: float = 0.0) -> Cases:
    none = np.zeros(len(position_m))
    return Cases(
        drive=np.array(kappa_per_m), even=none, rest_per_m=none, stiffness=none + 1.0,
        place_m=np.array(position_m), way=none + way,
    )  # fmt: skip


def force_of(one: Ritz, at: Cases) -> float:
    """Return F R^2/B of the first case."""
    return float(felt(one, held(one, at)[0], at)[0, 0]) * R**2


@pytest.mark.parametrize("length_mm", [50.0, 20.0, 4.5])
def test_contacts_of_constant_curvature_are_exact(length_mm: float) -> None:
    own = [r for r in rows("iv_v_vi_contact_constant_kappa_R40mm.csv") if r["l_mm"] == length_mm]
    at = cases([r["p_mm"] / 1e3 for r in own], [r["kappa_star_1_per_mm"] * 1e3 for r in own])
    one = ritz(length_mm / 1e3)
    found, ok, _ = held(one, at)
    assert np.all(ok)
    force = felt(one, found, at)[:, 0] * R**2
    np.testing.assert_allclose(force, [r["F_R2_over_B"] for r in own], atol=1e-9)
    np.testing.assert_allclose(found[:, PLACE] * 1e3, [r["shat_mm"] for r in own], atol=1e-8)


def test_contacts_of_varying_curvature_are_exact() -> None:
    for r in rows("v_varying_kappa_contact_R40mm.csv"):

        def rest(s, r=r):  # type: ignore[no-untyped-def]
            k = r["A_1_per_mm"] * np.exp(-s * 1e3 / r["lambda_mm"]) + r["k0_1_per_mm"]
            return 1e3 * (k + r["k1_1_per_mm2"] * s * 1e3)

        one = ritz(r["l_mm"] / 1e3, rest)
        force = force_of(one, cases([r["p_mm"] / 1e3], [0.0]))
        assert force == pytest.approx(r["F_R2_over_B"], abs=1e-8)


def test_free_strips_are_circular_arcs() -> None:
    for r in rows("iii_v_constant_curvature_arcs_R40mm.csv"):
        if r["l_mm"] > 40.0:
            one, bent = ritz(r["l_mm"] / 1e3), cases([np.nan], [1e3 * r["kappa_1_per_mm(k0+Me/B)"]])
            _, x, y, phi = lies(one, free(one, bent)[0], bent)
            ends = [1e3 * x[0, -1], 1e3 * y[0, -1], phi[0, -1]]
            assert ends == pytest.approx([r["x_l_mm"], r["y_l_mm"], r["phi_l_rad"]], abs=1e-6)


def test_a_drawn_sheet_passes_the_contact_and_has_its_length() -> None:
    one, at = ritz(50e-3), cases([0.01, 0.02], [30.0, -20.0])
    found = held(one, at)[0]
    s, *lie = lies(one, found, at, None, np.linspace(0.0, 50e-3, 2001))
    for k, p in enumerate((0.01, 0.02)):
        touch = [np.interp(found[k, PLACE], s, v[k]) for v in lie[:2]]
        assert touch == pytest.approx([R * np.cos(p / R), R * np.sin(p / R)], abs=1e-7)
        length = np.sum(np.hypot(np.diff(lie[0][k]), np.diff(lie[1][k])))
        assert length == pytest.approx(50e-3, abs=1e-7)


def test_a_free_strip_hangs_as_a_light_cantilever_does() -> None:
    load, length = 1e-5, 50e-3
    one, straight = ritz(length, weight_N_per_m=load), cases([np.nan], [0.0])
    x, extra = free(one, straight)
    _, _, y, _ = lies(one, x, straight, extra)
    assert y[0, -1] == pytest.approx(-load * length**4 / (8.0 * B), rel=1e-5)


def test_weight_bends_a_held_sheet_as_a_propped_cantilever() -> None:
    one = ritz(R + 1e-6, weight_N_per_m=1e-5)
    force = force_of(one, cases([0.0], [0.0])) * B / R**2
    assert force == pytest.approx(-3.0 / 8.0 * 1e-5 * R, rel=2e-3)


@pytest.mark.parametrize("length_mm", [41.0, 5.0])
def test_a_clamp_that_turns_makes_a_cantilever_softer_by_its_lever(length_mm: float) -> None:
    at, give, lever = cases([1e-4], [0.0]), 2e3, R - length_mm / 1e3
    stiff, soft = (force_of(ritz(length_mm / 1e3, clamp_rad_per_Nm=c), at) for c in (0.0, give))
    bends = (R**3 - max(lever, 0.0) ** 3) / (3.0 * B)
    assert stiff / soft == pytest.approx(1.0 + give * R**2 / bends, rel=1e-3)


def test_a_joint_that_turns_makes_a_short_sheet_softer_by_its_lever() -> None:
    at, give, lever = cases([1e-4], [0.0]), 2e3, 35e-3
    stiff, soft = (force_of(ritz(5e-3, joint_rad_per_Nm=c), at) for c in (0.0, give))
    bends = (R**3 - lever**3) / (3.0 * B)
    assert stiff / soft == pytest.approx(1.0 + give * lever**2 / bends, rel=1e-3)


def test_a_cell_that_gives_way_stands_where_its_force_has_pushed_it() -> None:
    give = 2.0
    soft, at = ritz(50e-3, cell_m_per_N=give), cases([0.02], [0.0])
    force = force_of(soft, at) * B / R**2
    there = cases([0.02 + give * force], [0.0])
    assert force_of(ritz(50e-3), there) * B / R**2 == pytest.approx(force, rel=1e-9)


def test_rolls_that_rub_hold_the_sheet_along_itself() -> None:
    one, at = ritz(50e-3, friction=1.0), cases([0.0, 0.02], [30.0, 30.0], way=0.1)
    found = held(one, at)[0]
    _, across, lean = felt(one, found, at).T
    angle = lean + at.place_m / R
    along = found[:, FORCE] * np.cos(angle) + found[:, FORCE + 1] * np.sin(angle)
    np.testing.assert_allclose(along, 0.1 * np.abs(across), rtol=1e-6)


def test_rolls_that_rub_narrow_the_swing_of_the_force_at_each_position() -> None:
    design = Design(positions_m={"long": Design().positions_m["long"]}, readings=2, series=False)
    rubbing = {n: k.typical for n, k in WORLD.kinds.items() if k.known_as == "roll_friction"}
    bare, rubbed = (swings_N(design, hidden) for hidden in ({}, rubbing))
    assert len(bare) == 7
    assert np.all(rubbed < bare - 1e-6)


def swings_N(design: Design, hidden: dict[str, float]) -> FloatArray:
    """Return force at +V less that at -V, at each position."""
    conditions = WORLD.measure(design, hidden, 4, exact=True).conditions
    high, low = (
        [np.mean([r.force_N for r in c.used()]) for c in conditions if c.voltage_V == volts]
        for volts in design.voltages_V
    )
    return np.array(high) - np.array(low)


def test_without_rubbing_the_cell_feels_the_normal_force_by_its_lean() -> None:
    one, at = ritz(50e-3), cases([0.0, 0.01, 0.03], [30.0, -20.0, 10.0])
    along, across, lean = felt(one, held(one, at)[0], at).T
    np.testing.assert_allclose(along, across * np.cos(lean), atol=1e-7)


def test_readings_are_steps_of_the_board() -> None:
    for c in WORLD.measure(FEW, {}, 3).conditions:
        steps = np.array([r.force_N for r in c.readings]) / STEP_N
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_the_zero_walks_at_random() -> None:
    time = np.arange(0.0, 18.0, 0.05)
    runs = [Run(k, "long", 0.0, 0, 0.0, 0.0, (0.0, 1.0)) for k in range(150)]
    shown = np.stack([RunNoise(5, run, exact=False).readings(time) for run in runs])
    ends = np.mean(shown[:, -40:], axis=1) - np.mean(shown[:, :40], axis=1)
    assert WALK_N * 4.0 < np.std(ends) < 30e-6
    assert 40e-6 < np.std(shown[:, 0]) < 75e-6
    assert not np.any(RunNoise(5, runs[0], exact=True).readings(time))


def test_the_fit_finds_sheets_with_nothing_hidden_within_its_uncertainty() -> None:
    z = []
    for seed in range(3):
        found, true = fit(WORLD.measure(Design(), {}, seed)), specimens(seed)
        for name, one in found.configurations.items():
            stiffness, per_m = true[name].stiffness_Nm2, true[name].eibm_per_m
            z.append((one.B.value - stiffness) / one.B.sigma)
            for volts, share in ((2.0, 1.0), (-2.0, -true[name].negative)):
                eibm = one.eibm[volts]
                z.append((eibm.value - stiffness * per_m * share) / eibm.sigma)
    assert np.max(np.abs(z)) < 4.0
    assert 0.5 < float(np.sqrt(np.mean(np.square(z)))) < 1.6


def test_a_place_out_of_reach_is_told_as_such() -> None:
    far = Design(positions_m={"long": (0.075,)}, readings=2, series=False)
    conditions = WORLD.measure(far, {}, 1).conditions
    bent = next(c for c in conditions if c.voltage_V == -2.0)
    assert bent.curve is None
    assert not any(r.valid for r in bent.readings)
    assert "not reachable" in bent.readings[0].why


def test_every_kind_stays_finite_up_to_its_largest_size() -> None:
    for name, kind in WORLD.kinds.items():
        for size in (kind.largest, 0.5 * kind.largest):
            found = WORLD.measure(FEW, {name: size}, 5)
            shown = [r for c in found.conditions for r in c.readings if r.valid]
            assert len(shown) > 0.7 * sum(len(c.readings) for c in found.conditions), name
            assert all(np.isfinite(r.force_N) and abs(r.force_N) < 0.1 for r in shown), name


def test_readings_without_series_are_those_with_series() -> None:
    designs = [
        Design(positions_m={"long": (0.01,), "short": (0.02,)}, readings=3, series=series)
        for series in (True, False)
    ]
    # what lies between the readings counts
    history = {"load_cell_hysteresis", "roll_sticking", "roll_friction"}
    for name, kind in WORLD.kinds.items():
        if kind.known_as not in history:
            both = [WORLD.measure(d, {name: kind.typical}, 2, exact=True) for d in designs]
            for a, b in zip(both[0].conditions, both[1].conditions, strict=True):
                forces = [[r.force_N for r in c.readings] for c in (a, b)]
                np.testing.assert_allclose(*forces, atol=1e-9, err_msg=name)


def test_there_are_enough_kinds_to_compare_names_parameters_and_locations() -> None:
    kinds = WORLD.kinds.values()
    further = [k for k in kinds if k.known_as is None]
    assert len({k.known_as for k in kinds if k.known_as}) >= 26
    assert sum(k.own_form for k in kinds) >= 10
    assert len(further) >= 20
    assert {where for k in further for where in k.locations} == set(LOCATIONS)
