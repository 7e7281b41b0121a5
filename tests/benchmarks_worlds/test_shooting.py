"""The world that shoots from the clamp: exact solutions, and the fit of what it measures."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._shooting_equilibrium import Lanes, Shooting, Strip, Surroundings
from benchmarks.worlds.generators._shooting_specimen import specimens
from benchmarks.worlds.generators.shooting import WORLD
from model import fit

pytestmark = pytest.mark.thorough

REFERENCE = Path(__file__).parents[1] / "data" / "reference"
R, B = 40e-3, 1.27e-6


def rows(name: str) -> list[dict[str, float]]:
    with (REFERENCE / name).open(encoding="utf-8") as file:
        return [
            {k: float(v) for k, v in row.items() if k not in {"case", "taylor_residual"}}
            for row in csv.DictReader(file)
        ]


def strip(length_m: float, **more: object) -> Strip:
    given = {"elongation_m": 0.0 if length_m > R else 60e-3, "rest_per_m": np.zeros_like}
    return Strip(length_m=length_m, radius_m=R, stiffness_Nm2=B, **{**given, **more})


def lanes(position_m: list[float], kappa_per_m: list[float]) -> Lanes:
    n = len(position_m)
    return Lanes.of(np.array(position_m), B * np.array(kappa_per_m), np.full(n, B))


@pytest.mark.parametrize("length_mm", [50.0, 20.0, 4.5])
def test_contacts_of_constant_curvature_are_exact(length_mm: float) -> None:
    cases = [r for r in rows("iv_v_vi_contact_constant_kappa_R40mm.csv") if r["l_mm"] == length_mm]
    held = lanes([r["p_mm"] / 1e3 for r in cases], [r["kappa_star_1_per_mm"] * 1e3 for r in cases])
    found = Shooting(strip(length_mm / 1e3), Surroundings()).solve(held)
    force = found.of_object()[0] * R**2 / B
    assert np.all(found.closed)
    np.testing.assert_allclose(force, [r["F_R2_over_B"] for r in cases], atol=2e-6)
    np.testing.assert_allclose(found.contact_m * 1e3, [r["shat_mm"] for r in cases], atol=1e-5)


def test_contacts_of_varying_curvature_are_exact() -> None:
    for r in rows("v_varying_kappa_contact_R40mm.csv"):

        def rest(s, r=r):  # type: ignore[no-untyped-def]
            k = r["A_1_per_mm"] * np.exp(-s * 1e3 / r["lambda_mm"]) + r["k0_1_per_mm"]
            return 1e3 * (k + r["k1_1_per_mm2"] * s * 1e3)

        one = strip(r["l_mm"] / 1e3, rest_per_m=rest)
        found = Shooting(one, Surroundings()).solve(lanes([r["p_mm"] / 1e3], [0.0]))
        assert found.of_object()[0][0] * R**2 / B == pytest.approx(r["F_R2_over_B"], abs=2e-6)


def test_a_free_strip_hangs_as_a_light_cantilever_does() -> None:
    q, length = 1e-4, 50e-3
    tip = Shooting(strip(length), Surroundings(weight_N_per_m=q)).free(lanes([0.0], [0.0]))
    assert tip.y_m[0, -1] == pytest.approx(-q * length**4 / (8.0 * B), rel=1e-3)


def test_rolls_that_rub_hold_the_sheet_along_itself() -> None:
    held = lanes([0.0, 0.02], [30.0, 30.0])
    held.friction[:] = 0.1
    found = Shooting(strip(50e-3), Surroundings()).solve(held)
    c, s = np.cos(found.angle_rad), np.sin(found.angle_rad)
    fx, fy = found.force_N
    np.testing.assert_allclose(fx * c + fy * s, 0.1 * (fx * s - fy * c), atol=1e-9)


def test_the_fit_finds_sheets_with_nothing_hidden_within_its_uncertainty() -> None:
    z = []
    for seed in range(3):
        found, true = fit(WORLD.measure(Design(), {}, seed)), specimens(seed)
        for name, one in found.configurations.items():
            stiffness = true[name].strip.stiffness_Nm2
            z.append((one.B.value - stiffness) / one.B.sigma)
            for volts, per_m in zip((2.0, -2.0), true[name].eibm_per_m, strict=True):
                eibm = one.eibm[volts]
                z.append((eibm.value - stiffness * per_m) / eibm.sigma)
    assert np.max(np.abs(z)) < 4.0
    assert 0.5 < float(np.sqrt(np.mean(np.square(z)))) < 1.6


def test_a_place_out_of_reach_is_told_as_such() -> None:
    far = Design(positions_m={"long": (0.052,)}, readings=2, series=False)
    conditions = WORLD.measure(far, {}, 1).conditions
    bent = next(c for c in conditions if c.voltage_V == 2.0)
    assert bent.curve is None
    assert not any(r.valid for r in bent.readings)
    assert "not reachable" in bent.readings[0].why


def test_every_kind_stays_finite_up_to_its_largest_size() -> None:
    few = Design(positions_m={"long": (0.0, 0.025), "short": (0.0, 0.025)}, readings=2)
    for name, kind in WORLD.kinds.items():
        for size in (kind.largest, 0.5 * kind.largest):
            found = WORLD.measure(few, {name: size}, 5)
            shown = [r for c in found.conditions for r in c.readings if r.valid]
            assert len(shown) > 0.7 * sum(len(c.readings) for c in found.conditions), name
            assert all(np.isfinite(r.force_N) and abs(r.force_N) < 0.1 for r in shown), name


def test_a_sheet_that_sticks_is_weighed_as_any_where_nothing_touches_it() -> None:
    few = Design(positions_m={"long": (0.0, 0.025)}, readings=2, free_shapes=1)
    found = WORLD.measure(few, {"roll_sticking": 0.5}, 5)
    free = [r for c in found.conditions if c.position_m is None for r in c.readings]
    assert free
    assert all(np.isfinite(r.force_N) for r in free)
