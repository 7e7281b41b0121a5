"""Problems solved side by side, and one by one, are the same problems."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.mechanics.equilibrium import Problems, SolverStatus, problems, solve
from model.mechanics.field import Field
from model.mechanics.tip_load import tip_load

R = 0.04


@pytest.fixture(autouse=True)
def small_batches_side_by_side(monkeypatch):
    """As only large ones are otherwise."""
    monkeypatch.setattr("model.mechanics.kernel.batch.FEW", 4)


def several(count: int, length: float, panels: int, soft: bool) -> Problems:
    random = np.random.default_rng(count)
    s = np.linspace(0.0, length, panels + 1)
    kappa = [Field.linear(s, random.uniform(-10.0, 45.0, panels + 1), length) for _ in range(count)]
    softness = Field.linear(s, random.uniform(0.7, 1.6, panels + 1), length) if soft else None
    return problems(kappa, random.uniform(-0.1, 0.8, count), R, 0.06, softness)


def alone(many: Problems, k: int) -> Problems:
    return replace(many, kappa=many.kappa[k : k + 1], angle_rad=many.angle_rad[k : k + 1])


@pytest.mark.parametrize("count", [5, 8, 97, 200])
@pytest.mark.parametrize(("length", "panels"), [(0.0045, 1), (0.02, 3), (0.05, 1), (0.05, 5)])
@pytest.mark.parametrize("soft", [False, True])
def test_a_batch_is_what_its_problems_are_alone(count, length, panels, soft):
    many = several(count, length, panels, soft)
    found = solve(many)
    assert np.all(found.status == SolverStatus.SOLVED)
    for k in range(0, count, max(1, count // 12)):
        one = solve(alone(many, k))
        assert found.nu[k] * R * R == pytest.approx(one.nu[0] * R * R, abs=2e-11)
        assert found.s_hat_m[k] == pytest.approx(one.s_hat_m[0], rel=2e-11)
        assert found.phi_hat_rad[k] == pytest.approx(one.phi_hat_rad[0], abs=2e-11)
        np.testing.assert_allclose(found.psi[k], one.psi[0], atol=2e-11)


def test_who_else_is_in_a_batch_changes_no_more_than_rounding():
    """A processor with wide lanes rounds what fills them otherwise than what is left over."""
    many = several(40, 0.05, 5, soft=False)
    order = np.random.default_rng(0).permutation(40)
    mixed = replace(
        many, kappa=np.ascontiguousarray(many.kappa[order]), angle_rad=many.angle_rad[order]
    )
    np.testing.assert_allclose(solve(mixed).nu, solve(many).nu[order], rtol=1e-13)


def test_what_the_lanes_cannot_solve_is_solved_by_itself():
    """Far round, and out of reach, among what is easy."""
    random = np.random.default_rng(3)
    kappa = random.uniform(0.0, 40.0, 60)
    angles = random.uniform(0.0, 0.7, 60)
    kappa[::7], angles[::7] = 140.0, -1.3
    angles[3::7] = 1.4
    fields = [Field.constant(k, 0.05) for k in kappa]
    found = solve(problems(fields, angles, R))
    singly = [solve(problems(f, a, R)) for f, a in zip(fields, angles, strict=True)]
    assert found.status.tolist() == [int(one.status[0]) for one in singly]
    assert set(found.status.tolist()) == {SolverStatus.SOLVED, SolverStatus.SLIPPED}
    np.testing.assert_allclose(
        found.nu * R * R, [one.nu[0] * R * R for one in singly], atol=2e-11
    )  # fmt: skip


def test_some_of_a_batch_may_have_a_start():
    many = several(30, 0.05, 5, soft=False)
    whole = solve(many)
    begin = replace(whole, nu=np.where(np.arange(30) % 3 == 0, np.nan, whole.nu))
    np.testing.assert_allclose(solve(many, begin).nu, whole.nu, atol=1e-10 / R**2)


@pytest.mark.parametrize("follows", [False, True])
def test_a_softer_sheet_under_a_tip_load_is_the_stiffer_one_under_more(follows):
    kappa, s = Field.linear(np.array([0.0, 0.05]), np.array([25.0, 5.0]), 0.05), 0.05
    load = (0.4 / s**2, -1.5 / s**2)
    soft = tip_load(kappa, load, follows, Field.constant(1.7, s))
    plain = tip_load(kappa, (1.7 * load[0], 1.7 * load[1]), follows)
    assert soft.tip_rad == pytest.approx(plain.tip_rad, abs=1e-12)
    np.testing.assert_allclose(soft.y_m, plain.y_m, atol=1e-14)
    # (1) at the clamp, from the moment: the curvature that a parabola through the clamp shows
    i = np.argsort(soft.s_m)[:6]
    bend = np.polyfit(soft.s_m[i], soft.y_m[i], 5)[-3] * 2.0
    assert bend == pytest.approx(25.0 + 1.7 * soft.root_moment_per_m, rel=2e-3)
