"""The linear model about a state at rest: closed form, static slope, small motions in time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from model.dynamics import (
    VACUUM,
    ContactSetup,
    Elongation,
    HeldVoltage,
    LineModes,
    Resolution,
    Simulation,
)
from model.dynamics.linear.linear_model import linear_model, read_by
from model.dynamics.linearised import linearise
from model.measurements import ModelError
from model.mechanics.equilibrium import problems, solve
from model.mechanics.field import Field
from tests.model.dynamics.sheets import (
    FINE,
    LINE,
    RADIUS_M,
    SHORT,
    B,
    at_rest,
    beam,
    model_of,
    straight,
)

TABLES = Path(__file__).parents[2] / "data" / "reference" / "dynamics"
EXACT = np.genfromtxt(TABLES / "viii_frequency_response_straight.csv", delimiter=",", names=True)
SESSION = Resolution(degrees=(8, 3), free_degrees=10)  # of the speed figure


def errors(system, output, real, imaginary, below_hz):
    exact = EXACT[real] + 1j * EXACT[imaginary]
    found = system.output(output).response(EXACT["f_Hz"])[:, 0, 0]
    return (np.abs(found / exact - 1))[EXACT["f_Hz"] <= below_hz]


@pytest.mark.parametrize(("resolution", "below_hz"), [(SESSION, 20.0), (FINE, 200.0)])
def test_force_is_that_of_the_closed_form(resolution, below_hz):
    system = straight(0.0, resolution)
    assert errors(system, "force_N", "force_re_N_per_V", "force_im", below_hz).max() < 1e-5


@pytest.mark.parametrize(("resolution", "below_hz"), [(SESSION, 10.0), (FINE, 200.0)])
def test_tip_and_current_are_those_of_the_closed_form(resolution, below_hz):
    system = straight(None, resolution)
    assert errors(system, "tip_m", "tip_y_re_m_per_V", "tip_y_im", below_hz).max() < 1e-5
    assert errors(system, "current_A", "current_re_A_per_V", "current_im", below_hz).max() < 1e-5


def test_a_free_sheet_presses_on_nothing():
    system = straight(None).output("force_N")
    assert not system.response(np.array([1.0, 10.0])).any()


def test_without_electrodes_there_is_no_model_from_voltage():
    small = replace(at_rest(beam(), None), line=None)
    with pytest.raises(ModelError, match="needs the sheet's electrodes"):
        linear_model(small)


def force_at(sheet, position_m, volts):
    """The static force of the sheet at a voltage that is held for ever."""
    line = LineModes(LINE, sheet.length_m, 12)
    charged = line.respond(np.zeros(12), np.array([np.inf]), np.array([volts]))[1]
    moment = sheet.moment_per_volt_Nm[0] / B
    kappa = Field.smooth(
        lambda s: sheet.rest(s) + moment * (line.at(s.ravel()) @ charged).reshape(s.shape),
        sheet.length_m,
    )
    batch = problems(kappa, [position_m / RADIUS_M], RADIUS_M, sheet.elongation.length_m)
    return float(solve(batch, accuracy="reference").force(B)[0])


@pytest.mark.parametrize(
    ("position_m", "sheet"),
    [(0.0, {}), (0.015, {}), (0.025, {}), (0.005, SHORT),
     (0.005, {"length_m": 0.02, "elongation": Elongation(length_m=0.04)})],
)  # fmt: skip
def test_about_any_state_the_static_gain_is_the_slope_of_the_static_force(position_m, sheet):
    made, step_V = beam(**sheet), 1e-3
    system = model_of(made, position_m).output("force_N")
    up, down = (force_at(made, position_m, volts) for volts in (step_V, -step_V))
    assert system.is_stable
    assert system.static_gain[0, 0] == pytest.approx((up - down) / (2 * step_V), rel=1e-6)


@pytest.mark.parametrize("position_m", [0.0, 0.025])
def test_a_small_step_of_voltage_moves_the_sheet_as_the_linear_model_says(position_m):
    step_V, times_s = 0.02, np.linspace(0.0, 0.2, 101)
    setup, sheet = ContactSetup(radius_m=RADIUS_M, position_m=position_m), beam(fluid=VACUUM)

    def moved_by(volts):
        drive = HeldVoltage(np.zeros(1), np.array([volts]))
        of = Simulation(sheet, setup, drive, resolution=Resolution(step_s=2e-4, rho=1.0))
        return of.advance(drive, times_s).force_N

    found = (moved_by(step_V) - moved_by(-step_V)) / (2 * step_V)
    wanted = model_of(sheet, position_m, SESSION).output("force_N").step(times_s)[:, 0]
    assert np.abs(found - wanted)[1:].max() < 2e-3 * np.abs(wanted).max()


UNEQUAL = {"moment_per_volt_Nm": (30 * B, 60 * B)}


def held_at(volts):
    return HeldVoltage(np.array([-100.0]), np.array([volts]))


def tip_m(sheet, volts):
    motion = Simulation(sheet, None, held_at(volts), resolution=FINE).advance(
        held_at(volts), np.zeros(1)
    )
    return float(motion.x_m[0, -1]), float(motion.y_m[0, -1]), float(motion.phi_rad[0, -1])


@pytest.mark.parametrize("volts", [2.0, -2.0])
def test_about_a_voltage_the_gain_is_that_of_its_sign(volts):
    sheet, step_V = beam(**UNEQUAL), 1e-3
    small = linearise(Simulation(sheet, None, held_at(volts), resolution=FINE))
    (x0, y0, _), (x1, y1, _) = (tip_m(sheet, volts + d) for d in (-step_V, step_V))
    phi = tip_m(sheet, volts)[2]
    wanted = (np.cos(phi) * (y1 - y0) - np.sin(phi) * (x1 - x0)) / (2 * step_V)
    found = linear_model(small).output("tip_m")
    assert found.static_gain[0, 0] == pytest.approx(wanted, rel=1e-5)
    x, y, _, _ = small.transfer(0.0, np.array([sheet.length_m]))
    assert abs(np.cos(phi) * y[0] - np.sin(phi) * x[0]) == pytest.approx(abs(wanted), rel=1e-5)


def test_at_0_V_the_gain_is_the_mean_of_both_signs():
    found = model_of(beam(**UNEQUAL), 0.015).static_gain
    mean = model_of(beam(moment_per_volt_Nm=(45 * B, 45 * B)), 0.015).static_gain
    np.testing.assert_allclose(found, mean)


def test_a_sheet_that_is_discharged_is_at_0_V():
    drive = HeldVoltage(np.array([-200.0, -100.0]), np.array([-2.0, 0.0]))
    small = linearise(Simulation(beam(**UNEQUAL), None, drive, resolution=FINE))
    assert small.moment_per_volt_Nm == pytest.approx(45 * B)


def test_where_the_voltage_changes_its_sign_along_the_sheet_each_place_has_its_own():
    drive = HeldVoltage(np.array([-100.0, -0.3]), np.array([-2.0, 2.0]))
    small = linearise(Simulation(beam(**UNEQUAL), None, drive, resolution=FINE))
    assert set(np.round(small.moment_per_volt_Nm / B)) == {30.0, 60.0}


def test_a_load_cell_reads_the_force_as_its_resonance_lets_it():
    system = straight(0.0)
    read = read_by(system, 100.0, 0.3)
    f = np.array([0.1, 10.0, 100.0, 150.0])
    cell = 1 / (1 - (f / 100.0) ** 2 + 2j * 0.3 * f / 100.0)
    for k, output in enumerate(system.outputs):
        wanted = system.response(f)[:, k, 0] * (cell if output == "force_N" else 1.0)
        np.testing.assert_allclose(read.response(f)[:, k, 0], wanted, rtol=1e-6)
    with pytest.raises(ModelError, match="must be positive"):
        read_by(system, 0.0, 0.3)


def test_a_load_cell_may_have_no_damping():
    system = straight(0.0).output("force_N")
    found = read_by(system, 100.0, 0.0).response(np.array([50.0]))[0, 0, 0]
    assert found == pytest.approx(system.response(np.array([50.0]))[0, 0, 0] / 0.75, rel=1e-6)


def first_frequency_hz(system):
    waves = system.poles[system.poles.imag > 0]
    return waves.imag.min() / (2 * np.pi)


@pytest.mark.parametrize(("position_m", "wanted_hz"), [(0.0, 22.8), (0.015, 21.1)])
def test_the_first_frequency_in_contact_is_that_of_a_prototype_in_air(position_m, wanted_hz):
    assert first_frequency_hz(model_of(beam(), position_m)) == pytest.approx(wanted_hz, abs=0.1)
    in_vacuum = model_of(beam(fluid=VACUUM), position_m)
    assert first_frequency_hz(in_vacuum) > wanted_hz + 0.1
