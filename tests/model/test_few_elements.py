"""A k0 that is stated as a table is solved on few elements, and the sheet lies where it lay."""

from __future__ import annotations

import numpy as np

from model.identification.likelihood.configuration.few_elements import APART_M, on_few_elements
from model.mechanics.equilibrium import problems, solve
from model.mechanics.field import Field
from model.mechanics.free_shape import free_shape

LENGTH_M, RADIUS_M, DEGREE = 0.05, 0.04, 14
WHOLE = np.array([0.0, 0.025, LENGTH_M])
S = np.linspace(0.0, LENGTH_M, 51)
SMOOTH = 24.0 * np.exp(-S / 0.03)


def table(values: np.ndarray) -> Field:
    return Field.linear(S[:: 50 // (len(values) - 1)], values, LENGTH_M)


def apart_m(one: Field, other: Field) -> float:
    s = np.linspace(0.0, LENGTH_M, 1001)
    (x, y, _), (u, v, _) = free_shape(one, s), free_shape(other, s)
    return float(np.max(np.hypot(x - u, y - v)))


def test_a_smooth_table_needs_no_more_elements_than_the_solver_asks_for() -> None:
    few = on_few_elements(table(SMOOTH), WHOLE, DEGREE)
    assert few.breaks_m.tolist() == WHOLE.tolist()
    assert apart_m(few, table(SMOOTH)) < 2.0 * APART_M


def test_a_coarse_table_keeps_the_kinks_that_move_the_sheet() -> None:
    exact = table(SMOOTH[::10])
    few = on_few_elements(exact, WHOLE, DEGREE)
    assert len(few.breaks_m) > len(WHOLE)
    assert apart_m(few, exact) < 2.0 * APART_M


def test_a_kink_where_an_element_ends_is_exact() -> None:
    few = on_few_elements(table(SMOOTH[::25]), WHOLE, DEGREE)
    assert few.breaks_m.tolist() == WHOLE.tolist()
    np.testing.assert_allclose(few(S), table(SMOOTH[::25])(S), rtol=1e-12)


def test_a_table_of_noise_keeps_many_elements() -> None:
    rough = table(SMOOTH + np.random.default_rng(1).normal(0.0, 3.0, len(S)))
    few = on_few_elements(rough, WHOLE, DEGREE)
    assert len(few.breaks_m) > 10
    assert apart_m(few, rough) < 3.0 * APART_M


def test_forces_are_those_of_the_table_to_six_digits() -> None:
    angles = np.array([-0.2, 0.1, 0.5])
    exact, few = table(SMOOTH), on_few_elements(table(SMOOTH), WHOLE, DEGREE)
    one, other = (solve(problems(rest, angles, RADIUS_M)) for rest in (exact, few))
    np.testing.assert_allclose(other.nu, one.nu, rtol=1e-6)
