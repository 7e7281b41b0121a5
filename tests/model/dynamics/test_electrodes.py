"""The RC line, the fluid and the material against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from model.dynamics import (
    ElectrodeLine,
    LineModes,
    Viscoelasticity,
    fluid_load,
    hydrodynamic_function,
)
from model.dynamics.material import relaxation
from tests.model.dynamics.cases import LINE, L, table


@pytest.mark.parametrize(("terms", "wanted_V"), [(10, 5e-8), (12, 3e-10)])
def test_the_line_follows_a_step_of_voltage_exactly(terms, wanted_V):
    wanted = table("v_rc_line_unit_step.csv")
    modes = LineModes(LINE, L, terms)
    times = np.concatenate([[0.0], wanted["t_s"]])
    ones = np.ones(len(wanted))
    found = modes.respond(np.zeros(terms), np.diff(times), ones)[1:]
    U = found @ modes.at(np.linspace(0.0, L, 6)).T
    for i in range(6):
        assert U[:, i] == pytest.approx(wanted[f"U_V_at_{10 * i}_mm"], abs=wanted_V)
    assert modes.current_A(found, ones) == pytest.approx(wanted["current_A"], rel=1e-9)


def test_a_held_voltage_is_exact_in_one_step_or_many():
    modes = LineModes(LINE, L, 12)
    few = modes.respond(np.zeros(12), np.array([0.1, 0.2]), np.array([2.0, -1.0]))
    many = modes.respond(np.zeros(12), np.full(30, 0.01), np.repeat([2.0, -1.0], [10, 20]))
    assert many[[10, 30]] == pytest.approx(few[1:], abs=1e-13)


def test_one_polynomial_is_the_lumped_rc_element():
    lumped = LineModes(LINE, L, 1)
    # source, then leak and capacitor with its ionic resistance side by side
    leak, ionic, C = 1.0 / (LINE.leak_S_per_m * L), LINE.bulk_ohm_m / L, 0.3 * L
    before = 1.0 / (1.0 / LINE.source_ohm + 1.0 / leak)
    assert lumped.rates_per_s == pytest.approx([1.0 / ((before + ionic) * C)])
    U = lumped.respond(np.zeros(1), np.array([1e3]), np.ones(1)) @ lumped.at(np.zeros(1)).T
    assert U[1, 0] == pytest.approx(leak / (leak + LINE.source_ohm))


def test_electrodes_of_no_resistance_are_lumped():
    good = ElectrodeLine(
        electrode_ohm_per_m=1e-6, capacitance_F_per_m=0.3, bulk_ohm_m=0.5, leak_S_per_m=0.1
    )
    times, ones = np.full(5, 0.05), np.ones(5)
    s = np.linspace(0.0, L, 3)
    many, one = LineModes(good, L, 8), LineModes(good, L, 1)
    U = many.respond(np.zeros(8), times, ones) @ many.at(s).T
    assert pytest.approx(one.respond(np.zeros(1), times, ones) @ one.at(s).T, abs=1e-8) == U


def test_in_the_end_only_the_leak_draws_current():
    modes = LineModes(LINE, L, 12)
    found = modes.respond(np.zeros(12), np.array([1e3]), np.ones(1))[1:]
    x, w = np.polynomial.legendre.leggauss(16)
    U = found @ modes.at(0.5 * L * (x + 1.0)).T
    assert modes.current_A(found, np.ones(1)) == pytest.approx(
        LINE.leak_S_per_m * (U @ w) * 0.5 * L, rel=1e-9
    )


def test_saders_function_is_that_of_the_table():
    wanted = table("vi_sader_gamma.csv")
    Re = wanted[wanted.dtype.names[0]]
    for shape in ("cylinder", "rectangle"):
        found = hydrodynamic_function(Re, circle=shape == "cylinder")
        assert found.real == pytest.approx(wanted[f"{shape}_real"], rel=1e-13)
        assert found.imag == pytest.approx(wanted[f"{shape}_imag"], rel=1e-13)


def test_water_adds_twenty_times_the_mass_of_the_sheet():
    load = fluid_load(0.011, 1000.0, 1e-3, 0.71)
    assert load.added_mass_kg_per_m == pytest.approx(21.0 * 5.775e-3, rel=0.03)
    assert load.normal_Ns_per_m2 > 0.0


def test_relaxation_is_exact_for_a_straight_line():
    tau, h = 0.02, np.array([1e-6, 1e-3, 0.5])
    e, early, late = relaxation(h, tau)
    # tau z' = y - z with z(0) = 1 and y = 2 + 3 t
    z = 2.0 + 3.0 * (h - tau) + (1.0 - 2.0 + 3.0 * tau) * np.exp(-h / tau)
    assert e + early * 2.0 + late * (2.0 + 3.0 * h) == pytest.approx(z, rel=1e-13)


def test_stiffness_is_relaxed_at_rest_and_instantaneous_when_fast():
    made = Viscoelasticity(B_Nm2=2.0, shares=(0.3, 0.2), times_s=(0.1, 3.0))
    assert made.complex_stiffness(0.0) == pytest.approx(2.0)
    assert made.complex_stiffness(1e9) == pytest.approx(3.0)
