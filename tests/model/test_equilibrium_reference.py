"""The equilibrium against exact solutions (20 digits; see data/reference/README.md)."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from model.mechanics.equilibrium import SolverStatus, problems, solve
from model.mechanics.field import Field
from model.mechanics.free_shape import free_shape
from model.mechanics.tip_load import tip_load

REFERENCE = Path(__file__).parents[1] / "data" / "reference"
R = 0.04


def table(name: str) -> list[dict[str, float]]:
    with (REFERENCE / name).open() as file:
        return [
            {k: float(v) for k, v in row.items() if k != "case"} for row in csv.DictReader(file)
        ]


@pytest.mark.parametrize(("accuracy", "wanted"), [("normal", 1e-9), ("reference", 1e-12)])
def test_contact_with_constant_curvature_is_exact(accuracy, wanted):
    for row in table("iv_v_vi_contact_constant_kappa_R40mm.csv"):
        length = row["l_mm"] * 1e-3
        kappa = Field.constant(row["kappa_star_1_per_mm"] * 1e3, length)
        batch = problems(kappa, row["p_mm"] * 1e-3 / R, R, 1.0, accuracy=accuracy)
        found = solve(batch, accuracy=accuracy)
        assert found.status[0] == SolverStatus.SOLVED
        assert found.nu[0] * R * R == pytest.approx(row["N_R2_over_B"], rel=wanted)
        assert found.force(1.0)[0] * R * R == pytest.approx(row["F_R2_over_B"], rel=wanted)
        assert found.s_hat_m[0] == pytest.approx(row["shat_mm"] * 1e-3, rel=wanted)
        assert found.phi_hat_rad[0] == pytest.approx(row["phihat_rad"], rel=wanted, abs=wanted)
        mean_moment = -found.nu[0] * found.mean_lever_m()[0]
        assert mean_moment == pytest.approx(row["Mbar_over_B_1_per_mm"] * 1e3, rel=wanted)


@pytest.mark.parametrize(("accuracy", "wanted"), [("normal", 1e-9), ("reference", 1e-11)])
def test_contact_with_varying_curvature_is_exact(accuracy, wanted):
    for row in table("v_varying_kappa_contact_R40mm.csv"):
        A, fall = row["A_1_per_mm"] * 1e3, row["lambda_mm"] * 1e-3
        k0, k1 = row["k0_1_per_mm"] * 1e3, row["k1_1_per_mm2"] * 1e6
        kappa = Field.smooth(
            lambda s, A=A, fall=fall, k0=k0, k1=k1: A * np.exp(-s / fall) + k0 + k1 * s,
            row["l_mm"] * 1e-3,
        )
        batch = problems(kappa, row["p_mm"] * 1e-3 / R, R, 1.0, accuracy=accuracy)
        found = solve(batch, accuracy=accuracy)
        assert found.nu[0] * R * R == pytest.approx(row["N_R2_over_B"], rel=wanted)
        assert found.s_hat_m[0] == pytest.approx(row["shat_mm"] * 1e-3, rel=wanted)
        assert found.phi_hat_rad[0] == pytest.approx(row["phihat_rad"], rel=wanted)


def test_free_arcs_are_exact():
    for row in table("iii_v_constant_curvature_arcs_R40mm.csv"):
        length = row["l_mm"] * 1e-3
        kappa = Field.constant(row["kappa_1_per_mm(k0+Me/B)"] * 1e3, length)
        x, y, phi = free_shape(kappa, np.linspace(0.0, length, 20))
        assert x[-1] == pytest.approx(row["x_l_mm"] * 1e-3, rel=1e-11)
        assert y[-1] == pytest.approx(row["y_l_mm"] * 1e-3, rel=1e-11, abs=1e-16)
        assert phi[-1] == pytest.approx(row["phi_l_rad"], rel=1e-13)


def test_the_force_vanishes_where_the_free_arc_crosses():
    for row in table("iii_v_constant_curvature_arcs_R40mm.csv"):
        if not np.isfinite(row["p_free_mm"]):
            continue
        kappa = Field.constant(row["kappa_1_per_mm(k0+Me/B)"] * 1e3, row["l_mm"] * 1e-3)
        found = solve(problems(kappa, row["p_free_mm"] * 1e-3 / R, R, 10.0))
        assert abs(found.nu[0]) * R * R < 1e-9
        assert found.s_hat_m[0] == pytest.approx(row["shat_free_mm"] * 1e-3, rel=1e-9)


def test_a_dead_tip_load_is_exact():
    straight = Field.constant(0.0, 1.0)
    for row in table("i_mattiasson_dead_tip_load.csv")[::4]:
        found = tip_load(straight, (0.0, row["FL2_over_EI"]), follows=False)
        assert 1.0 - found.tip_x_m == pytest.approx(row["u_over_L(axial shortening)"], rel=1e-11)
        assert found.tip_y_m == pytest.approx(row["w_over_L(deflection)"], rel=1e-12)
        assert found.tip_rad == pytest.approx(row["theta_tip_rad"], rel=1e-12)


def test_a_following_tip_load_is_exact():
    straight = Field.constant(0.0, 1.0)
    for row in table("ii_follower_tip_force.csv")[::4]:
        found = tip_load(straight, (0.0, row["FL2_over_EI"]), follows=True)
        assert found.tip_rad == pytest.approx(row["phi_tip_rad"], rel=1e-12)
        assert found.tip_x_m == pytest.approx(row["x_over_L"], abs=1e-12)
        assert found.tip_y_m == pytest.approx(row["y_over_L"], abs=1e-12)
