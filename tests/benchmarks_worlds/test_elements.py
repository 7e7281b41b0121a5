"""The world of finite elements: exact solutions, and the fit of what it measures."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._elements_beam import Beam, Blade, Cases, Setting
from benchmarks.worlds.generators._elements_shape import drawn
from benchmarks.worlds.generators._elements_specimen import specimens
from benchmarks.worlds.generators.elements import WORLD
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


def blade(length_m: float, **more: object) -> Blade:
    given = {"elongation_m": 0.0 if length_m > R else 60e-3, "rest_per_m": np.zeros_like}
    return Blade(length_m=length_m, radius_m=R, stiffness_Nm2=B, **{**given, **more})


def cases(position_m: list[float], kappa_per_m: list[float]) -> Cases:
    n = len(position_m)
    return Cases.of(np.array(position_m), B * np.array(kappa_per_m), np.full(n, B))


@pytest.mark.parametrize("length_mm", [50.0, 20.0, 4.5])
def test_contacts_of_constant_curvature_are_exact(length_mm: float) -> None:
    own = [r for r in rows("iv_v_vi_contact_constant_kappa_R40mm.csv") if r["l_mm"] == length_mm]
    held = cases([r["p_mm"] / 1e3 for r in own], [r["kappa_star_1_per_mm"] * 1e3 for r in own])
    found = Beam(blade(length_mm / 1e3), Setting()).solve(held)
    assert np.all(found.held)
    force = found.shown()[0] * R**2 / B
    np.testing.assert_allclose(force, [r["F_R2_over_B"] for r in own], atol=3e-6)
    np.testing.assert_allclose(found.contact_m * 1e3, [r["shat_mm"] for r in own], atol=2e-5)


def test_contacts_of_varying_curvature_are_exact() -> None:
    for r in rows("v_varying_kappa_contact_R40mm.csv"):

        def rest(s, r=r):  # type: ignore[no-untyped-def]
            k = r["A_1_per_mm"] * np.exp(-s * 1e3 / r["lambda_mm"]) + r["k0_1_per_mm"]
            return 1e3 * (k + r["k1_1_per_mm2"] * s * 1e3)

        one = blade(r["l_mm"] / 1e3, rest_per_m=rest)
        found = Beam(one, Setting()).solve(cases([r["p_mm"] / 1e3], [0.0]))
        assert found.shown()[0][0] * R**2 / B == pytest.approx(r["F_R2_over_B"], abs=1e-5)


def test_free_strips_are_circular_arcs() -> None:
    for r in rows("iii_v_constant_curvature_arcs_R40mm.csv"):
        if r["l_mm"] > 40.0:
            beam, bent = Beam(blade(r["l_mm"] / 1e3), Setting()), cases([0.0], [0.0])
            bent.moment_Nm[:] = B * 1e3 * r["kappa_1_per_mm(k0+Me/B)"]
            x, y, phi = drawn(beam, bent, beam.free(bent), np.linspace(0.0, 50e-3, 97))
            ends = [1e3 * x[0, -1], 1e3 * y[0, -1], phi[0, -1]]
            assert ends == pytest.approx([r["x_l_mm"], r["y_l_mm"], r["phi_l_rad"]], abs=1e-5)


def test_a_free_strip_hangs_as_a_light_cantilever_does() -> None:
    q, w, length = 1e-4, 1e-5, 50e-3
    for setting, drop in (
        (Setting(weight_N_per_m=q), q * length**4 / (8.0 * B)),
        (Setting(bead_N=w), w * length**3 / (3.0 * B)),
    ):
        beam, straight = Beam(blade(length), setting), cases([0.0], [0.0])
        _, y, _ = drawn(beam, straight, beam.free(straight), np.linspace(0.0, length, 97))
        assert y[0, -1] == pytest.approx(-drop, rel=2e-3)


def test_weight_bends_a_held_sheet_as_a_propped_cantilever() -> None:
    q = 1e-5
    beam, straight = Beam(blade(R + 1e-9), Setting(weight_N_per_m=q)), cases([0.0], [0.0])
    found = beam.solve(straight, beam._cold(straight))
    assert found.shown()[0][0] == pytest.approx(-3.0 / 8.0 * q * R, rel=2e-3)


def test_rolls_that_rub_hold_the_sheet_along_itself() -> None:
    held = cases([0.0, 0.02], [30.0, 30.0])
    held.rubbing[:] = 0.1
    found = Beam(blade(50e-3), Setting()).solve(held)
    c, s = np.cos(found.angle_rad), np.sin(found.angle_rad)
    fx, fy = found.force_N.T
    np.testing.assert_allclose(fx * c + fy * s, 0.1 * (fx * s - fy * c), atol=1e-9)


def test_the_fit_finds_sheets_with_nothing_hidden_within_its_uncertainty() -> None:
    z = []
    for seed in range(3):
        found, true = fit(WORLD.measure(Design(), {}, seed)), specimens(seed)
        for name, one in found.configurations.items():
            stiffness = true[name].blade.stiffness_Nm2
            z.append((one.B.value - stiffness) / one.B.sigma)
            for volts, per_m in zip((2.0, -2.0), true[name].eibm_per_m, strict=True):
                eibm = one.eibm[volts]
                z.append((eibm.value - stiffness * per_m) / eibm.sigma)
    assert np.max(np.abs(z)) < 4.0
    assert 0.5 < float(np.sqrt(np.mean(np.square(z)))) < 1.6


def test_every_kind_stays_finite_up_to_its_largest_size() -> None:
    few = Design(positions_m={"long": (0.0, 0.025), "short": (0.0, 0.025)}, readings=2)
    for name, kind in WORLD.kinds.items():
        for size in (kind.largest, 0.5 * kind.largest):
            found = WORLD.measure(few, {name: size}, 5)
            shown = [r for c in found.conditions for r in c.readings if r.valid]
            assert len(shown) > 0.7 * sum(len(c.readings) for c in found.conditions), name
            assert all(np.isfinite(r.force_N) and abs(r.force_N) < 0.1 for r in shown), name
