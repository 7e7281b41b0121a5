"""What must hold for every equilibrium, whatever the numbers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_bvp

from model.mechanics.equilibrium import Directions, SolverStatus, problems, solve
from model.mechanics.field import Field
from model.mechanics.free_shape import free_shape

R = 0.04
real = st.floats
curvatures = st.lists(real(-10.0, 45.0), min_size=3, max_size=6)
lengths = st.sampled_from([0.0045, 0.02, 0.05])
positions = real(-0.005, 0.03)
quick = settings(max_examples=40, deadline=None)


def field(values: list[float], length: float) -> Field:
    return Field.linear(np.linspace(0.0, length, len(values)), np.array(values), length)


def equilibrium(kappa, position, soft=None, accuracy="reference"):
    batch = problems(kappa, position / R, R, 0.06, soft, accuracy)
    found = solve(batch, accuracy=accuracy)
    assert found.status[0] == SolverStatus.SOLVED
    return found


@pytest.mark.slow
@quick
@given(curvatures, lengths, positions)
def test_deflection_angle_and_mean_moment_satisfy_equation_2(values, length, position):
    kappa = field(values, length)
    found = equilibrium(kappa, position)
    l_hat = found.l_hat_m[0]
    mean_moment = -found.nu[0] * found.mean_lever_m()[0]  # over B
    assert found.phi_hat_rad[0] == pytest.approx(
        kappa.integral(l_hat) + l_hat * mean_moment, abs=1e-9
    )


@pytest.mark.slow
@quick
@given(curvatures, lengths, positions)
def test_mirrored_sheet_gives_mirrored_answer(values, length, position):
    one = equilibrium(field(values, length), position)
    other = equilibrium(field([-v for v in values], length), -position)
    assert other.nu[0] * R * R == pytest.approx(-one.nu[0] * R * R, abs=1e-10)
    assert other.s_hat_m[0] == pytest.approx(one.s_hat_m[0], rel=1e-12)
    assert other.phi_hat_rad[0] == pytest.approx(-one.phi_hat_rad[0], abs=1e-12)


@pytest.mark.slow
@quick
@given(curvatures, lengths, positions, real(0.3, 3.0))
def test_a_sheet_and_arc_of_another_size_have_the_same_shape(values, length, position, factor):
    one = equilibrium(field(values, length), position)
    larger = field([v / factor for v in values], length * factor)
    other = solve(problems(larger, position / R, R * factor, 0.06 * factor))
    assert other.nu[0] * factor**2 == pytest.approx(one.nu[0], abs=1e-8 / R**2)
    assert other.s_hat_m[0] == pytest.approx(one.s_hat_m[0] * factor, rel=1e-9)


def test_force_is_proportional_to_stiffness():
    found = equilibrium(Field.constant(20.0, 0.05), 0.01)
    assert found.force(2.4e-6)[0] == pytest.approx(2.0 * found.force(1.2e-6)[0], rel=1e-15)


def test_twice_the_stiffness_everywhere_halves_what_a_force_does():
    kappa, length = Field.constant(20.0, 0.05), 0.05
    one = equilibrium(kappa, 0.01)
    other = equilibrium(kappa, 0.01, Field.constant(0.5, length))
    assert other.nu[0] == pytest.approx(2.0 * one.nu[0], rel=1e-12)
    assert other.s_hat_m[0] == pytest.approx(one.s_hat_m[0], rel=1e-12)


@pytest.mark.parametrize("length", [0.0045, 0.05])
def test_work_along_the_arc_is_the_change_of_elastic_energy(length):
    kappa = field([24.0, 15.0, 8.0], length)
    soft = Field.linear(np.array([0.0, length]), np.array([1.0, 1.5]), length)
    ends = (0.002, 0.028)

    def force(p: float) -> float:
        return float(equilibrium(kappa, p, soft).force(1.0)[0])

    def energy(p: float) -> float:
        found = equilibrium(kappa, p, soft)
        s, w = np.polynomial.legendre.leggauss(40)
        total, edges = 0.0, np.append(np.arange(0, 2) * length / 2, found.l_hat_m[0])
        for low, high in pairwise(edges):
            at = 0.5 * (low + high) + 0.5 * (high - low) * s
            bent = found.shapes(at).curvature_per_m[0] - kappa(at)
            total += 0.5 * (high - low) * float(w @ (0.5 * bent**2 / soft(at)))
        return total

    work = quad(force, *ends, epsabs=1e-10, epsrel=1e-10)[0]
    assert -work == pytest.approx(energy(ends[1]) - energy(ends[0]), rel=1e-8)


def test_force_of_the_short_sheet_is_a_line_whose_slope_does_not_depend_on_the_voltage():
    p, slopes = np.linspace(0.0, 0.03, 31), []
    for kappa in (28.0, 128.0, -52.0):
        force = solve(problems(Field.constant(kappa, 0.0045), p / R, R, 0.05)).force(1.0)
        line = np.polyfit(p, force, 1)
        assert np.max(np.abs(np.polyval(line, p) - force)) < 0.01 * np.ptp(force)
        slopes.append(line[0])
    assert np.ptp(slopes) < 0.02 * abs(np.mean(slopes))


def test_force_of_the_long_sheet_is_no_line():
    p = np.linspace(0.0, 0.03, 31)
    kappa = Field.smooth(lambda s: 24.0 * np.exp(-s / 0.04), 0.05)
    force = solve(problems(kappa, p / R, R)).force(1.0)
    slope = np.gradient(force, p)
    assert 0.2 < 1.0 - np.min(np.abs(slope)) / np.max(np.abs(slope)) < 0.4


@pytest.mark.parametrize("tip", [0.05, 0.4, 1.0, 1.4])
def test_straight_sheet_agrees_with_the_closed_form(tip):
    half = np.sqrt(tip)  # psi = u^2 removes the root's singularity
    I0 = quad(lambda u: 2.0 * u / np.sqrt(np.sin(u * u)), 0.0, half, epsabs=1e-13)[0]
    I1 = quad(lambda u: 2.0 * u * np.sqrt(np.sin(u * u)), 0.0, half, epsabs=1e-13)[0]
    beta = tip - np.arctan(I1 / (2.0 * np.sqrt(np.sin(tip))))
    found = solve(
        problems(Field.constant(0.0, 0.06), beta, R, accuracy="reference"), accuracy="reference"
    )
    assert -found.nu[0] * R * R == pytest.approx((4.0 * np.sin(tip) + I1**2) / 2.0, rel=1e-10)
    assert found.s_hat_m[0] == pytest.approx(R * I0 / np.sqrt(4.0 * np.sin(tip) + I1**2), rel=1e-10)


@pytest.mark.slow
@quick
@given(curvatures, lengths, positions, real(0.6, 1.8))
def test_compiled_and_numpy_engines_agree(values, length, position, stiffness):
    soft = Field.linear(np.array([0.0, length]), np.array([1.0, stiffness]), length)
    batch = problems(field(values, length), position / R, R, 0.06, soft)
    one, other = (solve(batch, engine=engine) for engine in ("compiled", "numpy"))
    assert other.nu[0] * R * R == pytest.approx(one.nu[0] * R * R, abs=1e-9)
    assert other.s_hat_m[0] == pytest.approx(one.s_hat_m[0], abs=1e-12)
    s = np.linspace(0.0, length + 0.03, 13)
    shapes = (one.shapes(s, "compiled"), other.shapes(s, "numpy"))
    for name in ("x_m", "y_m", "phi_rad"):
        np.testing.assert_allclose(getattr(shapes[0], name), getattr(shapes[1], name), atol=1e-10)


@pytest.mark.parametrize(("length", "elongation"), [(0.05, 0.0), (0.0045, 0.05), (0.02, 0.05)])
def test_sensitivities_agree_between_analytic_and_complex_step(length, elongation):
    kappa = field([24.0, 15.0, 8.0], length)
    soft = Field.linear(np.array([0.0, length]), np.array([1.0, 1.4]), length)
    batch = problems(kappa, [0.1, 0.5], R, elongation, soft)
    found, Q = solve(batch, accuracy="reference"), 6
    _, P, D = batch.kappa.shape
    dk, dc = np.zeros((1, Q, P, D)), np.zeros((1, Q, P, batch.softness.shape[2]))
    dk[0, 0, :, 0], dk[0, 1, 0, 1], dc[0, 2, :, 0] = 1.0, 1.0, 1.0
    rows = {name: np.zeros((1, Q)) for name in ("angle", "radius", "length")}
    for q, name in enumerate(rows):
        rows[name][0, 3 + q] = 1.0
    to = Directions.of(dk, dc, **rows)
    s = np.linspace(0.0, length + min(elongation, 0.02), 15)
    _, one = found.answers(s, to, "compiled")
    _, other = found.answers(s, to, "numpy")
    for name in ("nu", "s_hat", "phi_hat", "x", "y"):
        a, b = getattr(one, name), getattr(other, name)
        np.testing.assert_allclose(a, b, atol=1e-9 * np.max(np.abs(b)))


def test_a_warm_start_ends_at_the_same_equilibrium():
    kappa = [Field.constant(k, 0.05) for k in (5.0, 20.0, 35.0)]
    cold = solve(problems(kappa, [0.1, 0.4, 0.7], R))
    near = solve(problems([k * 1.1 for k in kappa], [0.1, 0.4, 0.7], R), start=cold)
    again = solve(near.problems)
    np.testing.assert_allclose(near.nu, again.nu, atol=1e-9 / R**2)


@pytest.mark.parametrize("seed", range(6))
def test_solve_bvp_finds_the_same(seed):
    random = np.random.default_rng(seed)
    length = 0.05 if seed % 2 else 0.0045
    a, fall = random.uniform(-20.0, 60.0), random.uniform(0.01, 0.05)
    beta = random.uniform(0.0, 0.7)
    kappa = Field.smooth(lambda s: a * np.exp(-s / fall) + 8.0, length)
    found = solve(problems(kappa, beta, R, 0.06))
    l_hat = float(found.l_hat_m[0])

    def rates(t, y, p):
        phi, x, z = y
        nu, s_hat, phi_hat = p[0] / R**2, p[1] * R, p[2]
        end = min(length, s_hat)
        lever = (R * np.cos(beta) - x) * np.cos(phi_hat) + (R * np.sin(beta) - z) * np.sin(phi_hat)
        k = a * np.exp(-t * end / fall) + 8.0 - nu * lever
        return end * np.stack([k, np.cos(phi), np.sin(phi)])

    def ends(ya, yb, p):
        beyond = max(p[1] * R - length, 0.0)
        x, z = yb[1] + beyond * np.cos(p[2]), yb[2] + beyond * np.sin(p[2])
        closed = [x - R * np.cos(beta), z - R * np.sin(beta), yb[0] - p[2]]
        return np.array([*ya, *closed])

    t = np.linspace(0.0, 1.0, 15)
    shape = found.shapes(t * l_hat)
    guess = np.stack([shape.phi_rad[0], shape.x_m[0], shape.y_m[0]]) * 0.97
    p0 = [found.nu[0] * R * R * 0.97, found.s_hat_m[0] / R * 1.003, found.phi_hat_rad[0] * 0.97]
    by_scipy = solve_bvp(rates, ends, t, guess, p=p0, tol=1e-8, max_nodes=20000)
    assert by_scipy.success
    assert by_scipy.p[0] == pytest.approx(found.nu[0] * R * R, abs=2e-5)
    assert by_scipy.p[1] * R == pytest.approx(found.s_hat_m[0], rel=1e-5)


def extreme(random, count, length):
    kappa = random.uniform(-150.0, 150.0, count)
    p = random.uniform(-0.06, 0.066, count)
    batch = problems([Field.constant(k, length) for k in kappa], p / R, R, 10.0)
    return solve(batch)


@pytest.mark.parametrize("length", [0.0045, 0.02, 0.05])
def test_extreme_problems_are_solved_from_cold(length):
    found = extreme(np.random.default_rng(1), 400, length)
    assert np.count_nonzero(found.status == SolverStatus.SOLVED) >= 399


@pytest.mark.slow
@pytest.mark.parametrize(("length", "low", "high"), [(0.0045, -70, 110), (0.05, -30, 60)])
def test_the_branch_found_from_cold_is_the_one_followed_from_the_free_shape(length, low, high):
    random = np.random.default_rng(2)
    count = 60
    kappa = [Field.constant(k, length) for k in random.uniform(low, high, count)]
    p = random.uniform(0.0, 0.03, count)
    cold = solve(problems(kappa, p / R, R, 0.06))
    walked = None
    s = np.linspace(0.0, 0.2, 4001)
    start = []
    for field_ in kappa:
        x, y, _ = free_shape(field_, s)
        i = int(np.argmax(np.hypot(x, y) >= R))
        start.append(np.arctan2(y[i], x[i]))
    for share in np.linspace(0.0, 1.0, 41):
        angles = np.array(start) * (1.0 - share) + share * p / R
        batch = problems(kappa, angles, R, 10.0)
        walked = solve(batch, walked)
    assert np.all(cold.status == SolverStatus.SOLVED)
    np.testing.assert_allclose(cold.nu, walked.nu, atol=1e-6 / R**2)
