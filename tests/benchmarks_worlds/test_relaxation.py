"""The world `relaxation`: exact solutions, laws of clamp and rolls, its noise, and what it shows.

That world is sealed. Nothing here names what it hides beyond the catalogue.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._relaxation_noise import (
    STEP_N,
    STRAY_N,
    STRAYS,
    WANDER_N,
    WHITE_N,
    RunNoise,
)
from benchmarks.worlds.generators._relaxation_shape import Held, contact_m, drawn, equilibria
from benchmarks.worlds.generators._relaxation_strip import Lanes, Setting, Strip
from benchmarks.worlds.generators.relaxation import WORLD
from benchmarks.worlds.session.layout import Run
from model.measurements import FloatArray

pytestmark = pytest.mark.thorough

REFERENCE = Path(__file__).parents[1] / "data" / "reference"
R, B = 40e-3, 1.27e-6
Rest = Callable[[FloatArray], FloatArray]  # curvature at rest along the sheet
FEW = Design(positions_m={"long": (0.0, 0.025), "short": (0.0, 0.025)}, readings=2)


def rows(name: str) -> list[dict[str, float]]:
    with (REFERENCE / name).open(encoding="utf-8") as file:
        return [
            {k: float(v) for k, v in row.items() if k not in {"case", "taylor_residual"}}
            for row in csv.DictReader(file)
        ]


def strip(length_m: float, rest: Rest = np.zeros_like) -> Strip:
    nodes = np.linspace(0.0, length_m, 1001)
    return Strip(
        name="exact", length_m=length_m, elongation_m=0.0 if length_m > R else 60e-3, radius_m=R,
        stiffness_Nm2=B, eibm_per_m=(30.0, 20.0), nodes_m=nodes, rest_per_m=rest(nodes),
    )  # fmt: skip


def lanes(one: Strip, position_m: list[float], kappa_per_m: list[float]) -> Lanes:
    found = Lanes.nominal(one, len(position_m))
    found.beta_rad[:] = np.array(position_m) / R
    found.eibm_Nm[:] = B * np.array(kappa_per_m)
    return found


def held(one: Strip, at: Lanes, setting: Setting | None = None) -> Held:
    found = equilibria(one, setting or Setting(), at)
    assert np.all(found.ok)
    return found


@pytest.mark.parametrize("length_mm", [50.0, 20.0, 4.5])
def test_contacts_of_constant_curvature_are_exact(length_mm: float) -> None:
    own = [r for r in rows("iv_v_vi_contact_constant_kappa_R40mm.csv") if r["l_mm"] == length_mm]
    one = strip(length_mm / 1e3)
    at = lanes(one, [r["p_mm"] / 1e3 for r in own], [r["kappa_star_1_per_mm"] * 1e3 for r in own])
    found = held(one, at)
    force = found.force_N(at) * R**2 / B
    np.testing.assert_allclose(force, [r["F_R2_over_B"] for r in own], atol=1e-7)
    place = contact_m(one, at, found.at) * 1e3
    np.testing.assert_allclose(place, [r["shat_mm"] for r in own], atol=1e-6)


def test_contacts_of_varying_curvature_are_exact() -> None:
    for r in rows("v_varying_kappa_contact_R40mm.csv"):

        def rest(s: FloatArray, r: dict[str, float] = r) -> FloatArray:
            k = r["A_1_per_mm"] * np.exp(-s * 1e3 / r["lambda_mm"]) + r["k0_1_per_mm"]
            return 1e3 * (k + r["k1_1_per_mm2"] * s * 1e3)

        one = strip(r["l_mm"] / 1e3, rest)
        at = lanes(one, [r["p_mm"] / 1e3], [0.0])
        assert held(one, at).force_N(at)[0] * R**2 / B == pytest.approx(r["F_R2_over_B"], abs=5e-6)


def test_free_strips_are_circular_arcs() -> None:
    for k in (1e-9, 20.0, 60.0):
        one, s = strip(50e-3), np.linspace(0.0, 50e-3, 101)
        at = lanes(one, [0.0], [k])
        at.free[:] = 1.0
        x, y, _ = drawn(one, Setting(), at, held(one, at).at, s)
        np.testing.assert_allclose(x[0], np.sin(k * s) / k, atol=1e-9)
        np.testing.assert_allclose(y[0], 2.0 * np.sin(0.5 * k * s) ** 2 / k, atol=1e-9)


def test_a_drawn_sheet_passes_the_contact_and_has_its_length() -> None:
    one, s = strip(50e-3), np.linspace(0.0, 50e-3, 4001)
    at = lanes(one, [0.01, 0.02], [30.0, -20.0])
    found = held(one, at)
    x, y, _ = drawn(one, Setting(), at, found.at, s)
    for k, p in enumerate((0.01, 0.02)):
        touch = [np.interp(contact_m(one, at, found.at)[k], s, v[k]) for v in (x, y)]
        assert touch == pytest.approx([R * np.cos(p / R), R * np.sin(p / R)], abs=1e-8)
        assert np.sum(np.hypot(np.diff(x[k]), np.diff(y[k]))) == pytest.approx(50e-3, abs=1e-8)


def test_weight_bends_a_free_and_a_held_sheet_as_a_light_cantilever() -> None:
    q, one = 1e-4, strip(50e-3)
    at = lanes(one, [0.0], [0.0])
    at.free[:], at.load_y_N_per_m[:] = 1.0, -q
    assert held(one, at).at.y_m[-1, 0] == pytest.approx(-q * 50e-3**4 / (8.0 * B), rel=1e-4)
    propped = strip(R + 1e-6)
    at = lanes(propped, [0.0], [0.0])
    at.load_y_N_per_m[:] = -1e-5
    assert held(propped, at).force_N(at)[0] == pytest.approx(-3.0 / 8.0 * 1e-5 * R, rel=1e-3)


def test_a_clamp_that_turns_makes_a_cantilever_softer_by_its_lever() -> None:
    one, give = strip(R + 1e-3), 2e3
    at = lanes(one, [1e-4], [0.0])
    loose = Setting(hinge=lambda m: (give * m, np.full_like(m, give)))
    stiff, soft = (held(one, at, setting).force_N(at)[0] for setting in (Setting(), loose))
    assert stiff / soft == pytest.approx(1.0 + give * 3.0 * B / R, rel=1e-3)


def test_rolls_that_rub_hold_the_sheet_along_itself() -> None:
    one = strip(50e-3)
    at = lanes(one, [0.0, 0.02], [30.0, 30.0])
    at.rub[:] = 0.1
    found = held(one, at).at
    c, s = np.cos(found.phi_rad[-1]), np.sin(found.phi_rad[-1])
    along, across = found.fx_N * c + found.fy_N * s, found.fy_N * c - found.fx_N * s
    np.testing.assert_allclose(along, 0.1 * np.abs(across), atol=1e-9)


def test_readings_scatter_as_their_parts_say() -> None:
    time = np.arange(0.5, 19.2, 0.6)
    runs = [Run(k, "long", 0.0, 0, 0.0, 0.0, (0.0, 1.0)) for k in range(300)]
    shown = np.stack([RunNoise(5, run, False).readings(time) for run in runs])
    parts = [WHITE_N**2, WANDER_N**2, STEP_N**2 / 12.0, STRAYS * 2.0 * STRAY_N**2]
    assert np.std(shown) == pytest.approx(np.sqrt(sum(parts)), rel=0.05)
    assert not np.any(RunNoise(5, runs[0], True).readings(time))


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


def test_there_are_enough_kinds_to_compare_names_and_parameters() -> None:
    kinds = WORLD.kinds.values()
    assert len({k.known_as for k in kinds if k.known_as}) >= 26
    assert sum(k.own_form for k in kinds) >= 10
    assert sum(k.known_as is None for k in kinds) >= 20
