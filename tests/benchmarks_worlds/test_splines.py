"""The sheet of the world `splines` against exact solutions (see data/reference/README.md)."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators.splines import WORLD, Cases, Sheet, solve, true_sheets

pytestmark = pytest.mark.thorough

REFERENCE = Path(__file__).parents[1] / "data" / "reference"
FEW = Design(positions_m={"long": (0.005, 0.025), "short": (0.005, 0.025)}, readings=3)


def rows(name: str) -> list[dict[str, float]]:
    with (REFERENCE / name).open(encoding="utf-8") as file:
        return [
            {k: float(v) for k, v in row.items() if k not in ("case", "taylor_residual")}
            for row in csv.DictReader(file)
        ]


def solved(length_m: float, rest, position_m: float) -> tuple[float, float]:  # type: ignore[no-untyped-def]
    """Return F R^2/B and s_hat (mm)."""
    sheet = Sheet(
        name="exact", length_m=length_m, elongation_m=0.05, radius_m=0.04, origin_rad=0.0,
        B_Nm2=1e-6, driven_per_m={1: 0.0, -1: 0.0}, rest=[rest],
    )  # fmt: skip
    none = np.zeros(1)
    found = solve(sheet, Cases(np.array([position_m]), none, none, none), np.array([0.0]))
    return float(found.tangential[0]) * 0.04**2, float(found.contact_m[0]) * 1e3


@pytest.mark.parametrize("row", rows("iv_v_vi_contact_constant_kappa_R40mm.csv")[::4])
def test_contact_of_a_sheet_with_constant_curvature_is_exact(row: dict[str, float]) -> None:
    k = row["kappa_star_1_per_mm"] * 1e3
    force, at_mm = solved(row["l_mm"] * 1e-3, lambda s: np.full_like(s, k), row["p_mm"] * 1e-3)
    assert force == pytest.approx(row["F_R2_over_B"], abs=1e-8)
    assert at_mm == pytest.approx(row["shat_mm"], abs=1e-7)


@pytest.mark.parametrize("row", rows("v_varying_kappa_contact_R40mm.csv")[::3])
def test_contact_of_a_sheet_with_varying_curvature_is_exact(row: dict[str, float]) -> None:
    def rest(s):  # type: ignore[no-untyped-def]
        falls = row["A_1_per_mm"] * np.exp(-s * 1e3 / row["lambda_mm"])
        return 1e3 * (falls + row["k0_1_per_mm"] + row["k1_1_per_mm2"] * s * 1e3)

    force, at_mm = solved(row["l_mm"] * 1e-3, rest, row["p_mm"] * 1e-3)
    assert force == pytest.approx(row["F_R2_over_B"], abs=1e-8)
    assert at_mm == pytest.approx(row["shat_mm"], abs=1e-7)


def test_equilibria_between_the_nodes_of_voltage_are_solved_ones() -> None:
    design = Design(positions_m=FEW.positions_m, readings=3, voltages_V=(1.5, -2.6))
    for c in WORLD.measure(design, {}, 5, exact=True).conditions:
        sheet, none = true_sheets(5)[c.configuration], np.zeros(1)
        case = Cases(np.array([c.position_m]), np.array([c.voltage_V / 2.0]), none, none)
        wanted = solve(sheet, case, np.array([0.0])).tangential[0] * sheet.B_Nm2
        assert force(c) == pytest.approx(wanted, abs=3e-7)


def force(condition) -> float:  # type: ignore[no-untyped-def]
    return float(np.mean([r.force_N for r in condition.used()]))


@pytest.mark.parametrize("kind", WORLD.kinds)
def test_the_largest_size_of_each_kind_is_solved(kind: str) -> None:
    found = WORLD.measure(FEW, {kind: WORLD.kinds[kind].largest}, 3)
    assert all(np.isfinite(r.force_N) for c in found.conditions for r in c.readings)


def test_weight_pulls_towards_negative_deflection_and_a_tilt_raises_the_force() -> None:
    plain = WORLD.measure(FEW, {}, 3, exact=True)
    for kind, sign in (("askew", -1.0), ("clamp_angle", 1.0), ("misplaced", -1.0), ("drum", 1.0)):
        other = WORLD.measure(FEW, {kind: WORLD.kinds[kind].typical}, 3, exact=True)
        for a, b in zip(plain.conditions, other.conditions, strict=True):
            assert sign * (force(b) - force(a)) > 0.0, (kind, a.position_m)


def test_what_never_was_is_refused_in_one_sentence() -> None:
    with pytest.raises(ValueError, match="no kind 'moonlight'"):
        WORLD.measure(FEW, {"moonlight": 1.0}, 3)
    with pytest.raises(ValueError, match="friction must be from 0 to"):
        WORLD.measure(FEW, {"friction": -0.1}, 3)


def test_free_curves_between_the_nodes_of_voltage_are_solved_ones() -> None:
    design = Design(
        positions_m={"long": (0.01,)}, readings=2, voltages_V=(1.7, -2.3), free_shapes=1
    )
    sheet, none = true_sheets(5)["long"], np.zeros(1)
    for c in WORLD.measure(design, {}, 5, exact=True).conditions:
        if c.position_m is None and c.curve is not None:
            case = Cases(np.array([np.nan]), np.array([c.voltage_V / 2.0]), none, none)
            wanted = solve(sheet, case, c.curve.s_m)
            assert np.max(np.abs(c.curve.x_m - wanted.x_m[0])) < 1e-6
            assert np.max(np.abs(c.curve.y_m - wanted.y_m[0])) < 1e-6
