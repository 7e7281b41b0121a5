"""The strip of the world `collocation` against exact solutions (see data/reference/README.md)."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators.collocation import (
    PINK_N,
    WORLD,
    Noise,
    Problem,
    Strip,
    solved,
    specimens,
)
from model.measurements import Condition

pytestmark = pytest.mark.thorough

REFERENCE = Path(__file__).parents[1] / "data" / "reference"
FEW = Design(positions_m={"long": (0.005, 0.025), "short": (0.005, 0.025)}, readings=3)


def rows(name: str) -> list[dict[str, str]]:
    with (REFERENCE / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def near(row: dict[str, str], k0) -> None:  # type: ignore[no-untyped-def]
    strip = Strip(
        name="exact", free_m=float(row["l_mm"]) / 1e3, bar_m=0.05, arc_m=0.04, B_Nm2=1e-6,
        bends_per_m=(0.0, 0.0), k0=[k0],
    )  # fmt: skip
    none = np.zeros(1)
    place = np.array([float(row["p_mm"]) / 1e3])
    found = solved(strip, Problem(place, none, none, none), none)
    assert found.along_arc[0] * 0.04**2 == pytest.approx(float(row["F_R2_over_B"]), abs=1e-9)
    assert found.contact_m[0] * 1e3 == pytest.approx(float(row["shat_mm"]), abs=1e-8)


@pytest.mark.parametrize("row", rows("iv_v_vi_contact_constant_kappa_R40mm.csv")[::4])
def test_contact_of_a_strip_with_constant_curvature_is_exact(row: dict[str, str]) -> None:
    near(row, lambda s: np.full_like(s, 1e3 * float(row["kappa_star_1_per_mm"])))


@pytest.mark.parametrize("row", rows("v_varying_kappa_contact_R40mm.csv")[::3])
def test_contact_of_a_strip_with_varying_curvature_is_exact(row: dict[str, str]) -> None:
    A, along, k, k1 = (
        float(row[n]) for n in ("A_1_per_mm", "lambda_mm", "k0_1_per_mm", "k1_1_per_mm2")
    )
    near(row, lambda s: 1e3 * (A * np.exp(-s * 1e3 / along) + k + k1 * s * 1e3))


def force(condition: Condition) -> float:
    return float(np.mean([r.force_N for r in condition.used()]))


def test_equilibria_between_the_levels_of_voltage_are_solved_ones() -> None:
    design = Design(positions_m=FEW.positions_m, readings=3, voltages_V=(1.6, -2.7))
    for c in WORLD.measure(design, {}, 5, exact=True).conditions:
        strip, none = specimens(5)[c.configuration], np.zeros(1)
        case = Problem(np.array([c.position_m]), np.array([c.voltage_V / 2.0]), none, none)
        wanted = solved(strip, case, none).along_arc[0] * strip.B_Nm2
        assert force(c) == pytest.approx(wanted, abs=3e-7)


@pytest.mark.parametrize("kind", WORLD.kinds)
def test_the_largest_size_of_each_kind_is_solved(kind: str) -> None:
    found = WORLD.measure(FEW, {kind: WORLD.kinds[kind].largest}, 3)
    assert all(np.isfinite(r.force_N) for c in found.conditions for r in c.readings)


def test_what_pulls_or_bends_upwards_raises_the_force() -> None:
    plain = WORLD.measure(FEW, {}, 3, exact=True)
    for kind, sign in (("leaning", -1.0), ("wedge", 1.0), ("pitch", -1.0), ("curlier", 1.0)):
        other = WORLD.measure(FEW, {kind: WORLD.kinds[kind].typical}, 3, exact=True)
        for a, b in zip(plain.conditions, other.conditions, strict=True):
            assert sign * (force(b) - force(a)) > 0.0, (kind, a.position_m)


def test_pink_noise_has_its_stated_size_and_falls_with_the_frequency() -> None:
    noise = Noise(7, exact=False)
    series = np.array([noise.pink_N(1536) for _ in range(200)])
    assert np.sqrt(np.mean(series**2)) == pytest.approx(PINK_N, rel=0.1)
    power = np.mean(np.abs(np.fft.rfft(series, axis=1)) ** 2, axis=0)
    assert np.mean(power[8:12]) / np.mean(power[80:120]) == pytest.approx(10.0, rel=0.3)


def test_what_never_was_is_refused_in_one_sentence() -> None:
    with pytest.raises(ValueError, match="no kind 'moonlight'"):
        WORLD.measure(FEW, {"moonlight": 1.0}, 3)
    with pytest.raises(ValueError, match="dragging_rolls is a size from 0 to"):
        WORLD.measure(FEW, {"dragging_rolls": -0.1}, 3)


def test_free_curves_between_the_levels_of_voltage_are_solved_ones() -> None:
    design = Design(
        positions_m={"long": (0.01,)}, readings=2, voltages_V=(1.7, -2.3), free_shapes=1
    )
    strip, none = specimens(5)["long"], np.zeros(1)
    for c in WORLD.measure(design, {}, 5, exact=True).conditions:
        if c.position_m is None and c.curve is not None:
            case = Problem(np.array([np.nan]), np.array([c.voltage_V / 2.0]), none, none)
            wanted = solved(strip, case, c.curve.s_m)
            assert np.max(np.abs(c.curve.x_m - wanted.x_m[0])) < 1e-6
            assert np.max(np.abs(c.curve.y_m - wanted.y_m[0])) < 1e-6
