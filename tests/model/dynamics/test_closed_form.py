"""The straight sheet's transfer functions against exact numbers (30 digits)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.model.dynamics.closed_form import blocked_force, charge, current, deflection, response
from tests.model.dynamics.sheets import STRAIGHT_SHEET as SHEET
from tests.model.dynamics.sheets import B

TABLES = Path(__file__).parents[2] / "data" / "reference" / "dynamics"


def table(name):
    return np.genfromtxt(TABLES / name, delimiter=",", names=True)


EXACT = table("viii_frequency_response_straight.csv")


@pytest.mark.parametrize(
    ("real", "imaginary", "transfer"),
    [
        ("tip_y_re_m_per_V", "tip_y_im", lambda p: deflection(SHEET, p, 0.05)),
        ("force_re_N_per_V", "force_im", lambda p: blocked_force(SHEET, p, 0.04)),
        ("current_re_A_per_V", "current_im", lambda p: current(SHEET, p)),
    ],
)
def test_tip_force_and_current_over_the_voltage_are_exact_from_0_01_to_200_hertz(
    real, imaginary, transfer
):
    exact = EXACT[real] + 1j * EXACT[imaginary]
    found = response(transfer, EXACT["f_Hz"])
    np.testing.assert_allclose(found, exact, rtol=1e-9)


def talbot(transfer, time_s, terms=24):
    """Invert a Laplace transform at one time (fixed Talbot contour); its poles are real here."""
    theta = (np.arange(terms) + 0.5) * np.pi / terms
    z = terms * (0.5017 * theta / np.tan(0.6407 * theta) - 0.6122 + 0.2645j * theta)
    cot = 1 / np.tan(0.6407 * theta)
    dz = 0.5017 * cot - 0.5017 * 0.6407 * theta / np.sin(0.6407 * theta) ** 2 + 0.2645j
    values = np.array([transfer(each / time_s) for each in z])
    return float(np.sum(np.exp(z) * values * dz).imag / time_s)


def test_the_lines_step_response_is_the_inverse_transform():
    exact = table("v_rc_line_unit_step.csv")
    for row in exact:
        found = [
            talbot(lambda p, s=s: charge(SHEET, p, s) / p, row["t_s"]) for s in (0.0, 0.01, 0.05)
        ]
        wanted = [row["U_V_at_0_mm"], row["U_V_at_10_mm"], row["U_V_at_50_mm"]]
        np.testing.assert_allclose(found, wanted, atol=1e-9)
        i = talbot(lambda p: current(SHEET, p) / p, row["t_s"])
        assert i == pytest.approx(row["current_A"], abs=1e-11)


def test_at_rest_the_force_is_that_of_a_blocked_beam():
    """U = 1 V everywhere without a leak: tip alpha l^2/2B, force 3 alpha/2a at the roller."""
    sheet = replace(SHEET, line=replace(SHEET.line, leak_S_per_m=0.0))
    assert deflection(sheet, 0.0, 0.05) == pytest.approx(30 * 0.05**2 / 2, rel=1e-12)
    assert blocked_force(sheet, 0.0, 0.04) == pytest.approx(1.5 * 30 * B / 0.04, rel=1e-12)
    nearly = blocked_force(sheet, 2j * np.pi * 1e-9, 0.04)
    assert nearly == pytest.approx(1.5 * 30 * B / 0.04, rel=1e-6)
