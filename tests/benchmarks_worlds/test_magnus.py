"""The world of plane motions: exact solutions, its noise, and the fit of what it measures.

That world is sealed. Nothing here names what it hides beyond the catalogue.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._magnus_motion import path_of
from benchmarks.worlds.generators._magnus_noise import ZERO_N, zero
from benchmarks.worlds.generators._magnus_rod import Cases, Rod, Setting, Sheets
from benchmarks.worlds.generators._magnus_shape import drawn, free
from benchmarks.worlds.generators._magnus_specimen import specimens
from benchmarks.worlds.generators.magnus import WORLD
from model import fit

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


def rod(length_m: float, **more: object) -> Rod:
    given = {"elongation_m": 0.0 if length_m > R else 60e-3, "rest_per_m": np.zeros_like}
    return Rod(length_m=length_m, radius_m=R, stiffness_Nm2=B, **{**given, **more})


def cases(position_m: list[float], kappa_per_m: list[float]) -> Cases:
    n = len(position_m)
    return Cases.of(np.array(position_m), B * np.array(kappa_per_m), np.full(n, B))


def test_a_motion_along_an_arc_is_exact() -> None:
    k, h, zero = 60.0, np.array([[7e-3]]), np.zeros(1)
    path = path_of(np.full((1, 6, 2), k), h, zero, zero, zero)
    turn = 6 * k * h[0, 0]
    assert path.x[0, -1] == pytest.approx(np.sin(turn) / k, abs=1e-12)
    assert path.y[0, -1] == pytest.approx((1.0 - np.cos(turn)) / k, abs=1e-12)


@pytest.mark.parametrize("length_mm", [50.0, 20.0, 4.5])
def test_contacts_of_constant_curvature_are_exact(length_mm: float) -> None:
    own = [r for r in rows("iv_v_vi_contact_constant_kappa_R40mm.csv") if r["l_mm"] == length_mm]
    held = cases([r["p_mm"] / 1e3 for r in own], [r["kappa_star_1_per_mm"] * 1e3 for r in own])
    found = Sheets(rod(length_mm / 1e3), Setting()).cold(held)
    assert np.all(found.held)
    force = found.shown()[0] * R**2 / B
    np.testing.assert_allclose(force, [r["F_R2_over_B"] for r in own], atol=2e-5)
    np.testing.assert_allclose(found.contact_m * 1e3, [r["shat_mm"] for r in own], atol=2e-4)


def test_contacts_of_varying_curvature_are_exact() -> None:
    for r in rows("v_varying_kappa_contact_R40mm.csv"):

        def rest(s, r=r):  # type: ignore[no-untyped-def]
            k = r["A_1_per_mm"] * np.exp(-s * 1e3 / r["lambda_mm"]) + r["k0_1_per_mm"]
            return 1e3 * (k + r["k1_1_per_mm2"] * s * 1e3)

        one = rod(r["l_mm"] / 1e3, rest_per_m=rest)
        found = Sheets(one, Setting()).cold(cases([r["p_mm"] / 1e3], [0.0]))
        assert found.shown()[0][0] * R**2 / B == pytest.approx(r["F_R2_over_B"], abs=2e-5)


def test_free_strips_are_circular_arcs() -> None:
    for r in rows("iii_v_constant_curvature_arcs_R40mm.csv"):
        if r["l_mm"] > 40.0:
            bent = cases([0.0], [1e3 * r["kappa_1_per_mm(k0+Me/B)"]])
            x, y, phi = free(Sheets(rod(r["l_mm"] / 1e3), Setting()), bent, np.array([50e-3]))
            ends = [1e3 * x[0, -1], 1e3 * y[0, -1], phi[0, -1]]
            assert ends == pytest.approx([r["x_l_mm"], r["y_l_mm"], r["phi_l_rad"]], abs=1e-6)


def test_a_drawn_sheet_passes_the_contact_and_has_its_length() -> None:
    sheets, held = Sheets(rod(50e-3), Setting()), cases([0.01, 0.02], [30.0, -20.0])
    found = sheets.cold(held)
    places = np.linspace(0.0, 50e-3, 2001)
    x, y, _ = drawn(sheets, held, found, places)
    for k, p in enumerate((0.01, 0.02)):
        at = [np.interp(found.contact_m[k], places, v[k]) for v in (x, y)]
        assert at == pytest.approx([R * np.cos(p / R), R * np.sin(p / R)], abs=1e-7)
        length = np.sum(np.hypot(np.diff(x[k]), np.diff(y[k])))
        assert length == pytest.approx(50e-3, abs=1e-7)


def test_a_free_strip_hangs_as_a_light_cantilever_does() -> None:
    q, length = 1e-4, 50e-3
    straight = cases([0.0], [0.0])
    straight.load_N_per_m[:] = q
    _, y, _ = free(Sheets(rod(length), Setting()), straight, np.array([length]))
    assert y[0, -1] == pytest.approx(-q * length**4 / (8.0 * B), rel=1e-3)


def test_weight_bends_a_held_sheet_as_a_propped_cantilever() -> None:
    straight = cases([0.0], [0.0])
    straight.load_N_per_m[:] = 1e-5
    found = Sheets(rod(R + 1e-9), Setting()).cold(straight)
    assert found.shown()[0][0] == pytest.approx(-3.0 / 8.0 * 1e-5 * R, rel=2e-3)


def test_a_clamp_that_turns_makes_a_cantilever_softer_by_its_lever() -> None:
    at, give = cases([1e-4], [0.0]), 2e3
    stiff, soft = (
        Sheets(rod(R + 1e-3), Setting(clamp_rad_per_Nm=c)).cold(at).shown()[0][0]
        for c in (0.0, give)
    )
    assert stiff / soft == pytest.approx(1.0 + give * 3.0 * B / R, rel=1e-3)


def test_rolls_that_rub_hold_the_sheet_along_itself() -> None:
    held = cases([0.0, 0.02], [30.0, 30.0])
    held.rubbing[:] = 0.1
    found = Sheets(rod(50e-3), Setting()).cold(held)
    c, s = np.cos(found.angle_rad), np.sin(found.angle_rad)
    fx, fy = found.force_N.T
    np.testing.assert_allclose(fx * c + fy * s, 0.1 * (fx * s - fy * c), atol=1e-9)


def test_the_zero_has_as_much_noise_in_each_octave() -> None:
    time = np.arange(0.0, 2000.0, 0.5)
    shown = np.stack([zero(seed, time) for seed in range(40)])
    assert np.std(shown) == pytest.approx(ZERO_N, rel=0.15)
    steps = [np.std(shown[:, k:] - shown[:, :-k]) for k in (4, 16, 64)]
    assert 1.1 < steps[1] / steps[0] < 1.6
    assert 1.05 < steps[2] / steps[1] < 1.5


def test_the_fit_finds_sheets_with_nothing_hidden_within_its_uncertainty() -> None:
    z = []
    for seed in range(3):
        found, true = fit(WORLD.measure(Design(), {}, seed)), specimens(seed)
        for name, one in found.configurations.items():
            stiffness = true[name].rod.stiffness_Nm2
            z.append((one.B.value - stiffness) / one.B.sigma)
            for volts, per_m in zip((2.0, -2.0), true[name].eibm_per_m, strict=True):
                eibm = one.eibm[volts]
                z.append((eibm.value - stiffness * per_m) / eibm.sigma)
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
    history = {"load_cell_hysteresis", "roll_sticking"}  # what lies between the readings counts
    for name, kind in WORLD.kinds.items():
        if kind.known_as not in history:
            both = [WORLD.measure(d, {name: kind.typical}, 2, exact=True) for d in designs]
            for a, b in zip(both[0].conditions, both[1].conditions, strict=True):
                forces = [[r.force_N for r in c.readings] for c in (a, b)]
                np.testing.assert_allclose(*forces, atol=1e-9, err_msg=name)


def test_there_are_enough_kinds_to_compare_names_and_parameters() -> None:
    kinds = WORLD.kinds.values()
    assert len({k.known_as for k in kinds if k.known_as}) >= 26
    assert sum(k.own_form for k in kinds) >= 10
    assert sum(k.known_as is None for k in kinds) >= 18
