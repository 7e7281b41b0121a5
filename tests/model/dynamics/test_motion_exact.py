"""The moving sheet against exact and converged motions, and the order of its steps."""

from __future__ import annotations

import numpy as np
import pytest

from model.dynamics import (
    UNDRIVEN,
    ClampTurn,
    ContactSetup,
    DynamicBeam,
    PrescribedMoment,
    Resolution,
    Simulation,
    Viscoelasticity,
    energy,
    linearise,
    simulate,
)
from model.mechanics.field import Field
from tests.cases import few
from tests.model.dynamics.cases import (
    CURVED,
    PULSES,
    STRAIGHT,
    L,
    R,
    arc_moment,
    driven,
    material,
    plain,
    table,
    under_tip_load,
)

TIP = np.array([L])


@pytest.mark.parametrize(("name", "position_m"), [("p0", 0.0), ("p15", 0.015)])
def test_pulses_in_contact(name, position_m):
    wanted = table(f"x_pulse_contact_{name}.csv")
    setup = ContactSetup(radius_m=R, position_m=position_m)

    def found(step_s):
        by = Resolution(step_s=step_s)
        return simulate(driven(), setup, PULSES, wanted["t_s"], s_m=TIP, resolution=by)

    for step_s, force_N, tip_m in ((1e-3, 7e-6, 3e-6), (2.5e-4, 5e-7, 2e-7)):
        motion = found(step_s)
        assert motion.force_N == pytest.approx(wanted["F_N"], abs=force_N)
        assert motion.x_m[:, 0] == pytest.approx(wanted["tip_x_m"], abs=tip_m)
        assert motion.y_m[:, 0] == pytest.approx(wanted["tip_y_m"], abs=tip_m)
        assert motion.s_hat_m == pytest.approx(wanted["s_hat_m"], abs=tip_m)
    # at an edge the table gives the current before it, as the motion does
    assert motion.current_A == pytest.approx(wanted["current_A"], abs=1e-12)


def test_pulses_without_contact():
    wanted = table("x_pulse_free.csv")
    motion = simulate(driven(), None, PULSES, wanted["t_s"], s_m=TIP)
    assert motion.x_m[:, 0] == pytest.approx(wanted["tip_x_m"], abs=5e-6)
    assert motion.y_m[:, 0] == pytest.approx(wanted["tip_y_m"], abs=5e-6)
    assert np.all(motion.force_N == 0.0)
    assert np.all(np.isnan(motion.s_hat_m))


def test_release_from_a_large_deflection():
    wanted, errors = table("ix_release_from_tip_load.csv"), []
    held, beam = under_tip_load(), plain(material=material(False, 2e-3))
    for step_s in (1e-3, 5e-4, 2.5e-4):
        by = Resolution(step_s=step_s, rho=1.0)
        motion = simulate(
            beam, None, UNDRIVEN, wanted["t_s"], s_m=TIP, released_from=held, resolution=by
        )
        assert motion.phi_rad[0, 0] == pytest.approx(wanted["tip_phi_rad"][0], abs=1e-9)
        gap = np.hypot(motion.x_m[:, 0] - wanted["tip_x_m"], motion.y_m[:, 0] - wanted["tip_y_m"])
        errors.append(gap.max())
    assert errors[0] < 1e-5
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)
    assert errors[2] < 6e-7


@pytest.mark.slow
@pytest.mark.parametrize("rho", few([1.0, 0.8, 0.0]))
def test_a_manufactured_large_motion_is_followed_to_second_order(rho):
    wanted, errors = table("vii_manufactured_arc.csv"), []
    times, s = np.unique(wanted["t_s"]), np.unique(wanted["s_m"])
    drive, arc = PrescribedMoment(arc_moment), Field.constant(40.0, L)
    for step_s in (5e-4, 2.5e-4):
        by = Resolution(step_s=step_s, rho=rho, tolerance_per_s2=1e-3, free_degrees=8)
        motion = simulate(plain(), None, drive, times, s_m=s, released_from=arc, resolution=by)
        off = np.abs(motion.curvature_per_m - wanted["k_per_m"].reshape(len(times), -1))
        errors.append(off.max() / 40.0)
        assert motion.x_m.ravel() == pytest.approx(wanted["x_m"], abs=0.5 * errors[-1] * L)
        assert motion.y_m.ravel() == pytest.approx(wanted["y_m"], abs=0.5 * errors[-1] * L)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)
    if rho == 0.8:
        assert errors[0] < 1.1e-4


def test_the_moment_of_the_manufactured_motion_is_that_of_the_table():
    wanted = table("vii_manufactured_arc.csv")
    found = arc_moment(np.unique(wanted["t_s"]), np.unique(wanted["s_m"]))
    assert found.ravel() == pytest.approx(wanted["Me_Nm"], abs=1e-18)


@pytest.mark.parametrize("rho", [1.0, 0.8, 0.0])
def test_a_small_free_motion_decays_as_the_closed_form(rho):
    row = table("i_cantilever_modes.csv")[0]
    root, times, errors = complex(row["kv_s_real"], row["kv_s_imag"]), np.array([0.1, 0.3]), []
    for step_s in (2e-3, 1e-3):
        by = Resolution(step_s=step_s, rho=rho, free_degrees=8, tolerance_per_s2=1e-9)
        one = Simulation(plain(material=material(False, 1e-3)), None, UNDRIVEN, resolution=by)
        mode = linearise(one).modes()[:, 0]
        mode *= 1e-6 / L / np.max(np.abs(mode))
        one.state.q[:], one.state.v[:] = mode, root.real * mode  # Re exp(root t) of the mode
        one.state.a[:] = one.state.a_mean[:] = (root**2).real * mode
        one.advance(UNDRIVEN, times)
        ends = np.round(times / step_s).astype(int)
        share = one.made.track.q[ends] @ mode / (mode @ mode)
        errors.append(np.abs(share - np.exp(root * times).real).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert errors[1] < 1e-3


def test_creep_of_a_standard_linear_solid():
    wanted = table("iv_sls_creep_uniform_moment.csv")
    g, tau, errors = 0.4, 0.1, []
    solid = Viscoelasticity(B_Nm2=1.27e-6, shares=(g,), times_s=(tau,))
    beam = plain(material=solid, mass_per_length_kg_per_m=1e-12)
    drive = PrescribedMoment(lambda t, s: 20.0 * solid.B_Nm2 + 0.0 * t * s)
    for step_s in (tau / 20.0, tau / 40.0):
        by = Resolution(step_s=step_s, free_degrees=4)
        one = Simulation(beam, None, drive, resolution=by)
        one.state.q[0] = wanted["k_per_m"][0]  # at once, with the instantaneous stiffness
        one.state.z[:] = 0.0
        motion = one.advance(drive, wanted["t_s"], TIP)
        errors.append(np.abs(motion.curvature_per_m[:, 0] / wanted["k_per_m"] - 1.0).max())
    assert errors[1] < 2e-6
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


def test_an_arm_that_is_spun_up_lags_as_the_converged_one():
    omega, rise, length = 6.0, 15.0, 10.0
    w = 2.0 * np.pi / rise
    turn = ClampTurn(
        angle_rad=lambda t: omega / rise * (0.5 * t**2 + (np.cos(w * t) - 1.0) / w**2),
        rate_rad_per_s=lambda t: omega / rise * (t - np.sin(w * t) / w),
        acceleration_rad_per_s2=lambda t: omega / rise * (1.0 - np.cos(w * t)),
    )
    arm = DynamicBeam(
        length_m=length, mass_per_length_kg_per_m=1.2, rest=Field.constant(0.0, length),
        material=Viscoelasticity(B_Nm2=1.4e4),
    )  # fmt: skip
    times = np.arange(6.6, 6.9, 0.02)
    motion = simulate(
        arm, None, UNDRIVEN, times, clamp=turn, s_m=np.array([length]),
        resolution=Resolution(step_s=0.01, free_degrees=8),
    )  # fmt: skip
    psi = turn.angle_rad(times)
    lag = -motion.x_m[:, 0] * np.sin(psi) + motion.y_m[:, 0] * np.cos(psi)
    along = motion.x_m[:, 0] * np.cos(psi) + motion.y_m[:, 0] * np.sin(psi) - length
    least = int(np.argmin(lag))
    parabola = np.polyfit(times[least - 1 : least + 2] - 6.763, lag[least - 1 : least + 2], 2)
    assert times[least] == pytest.approx(6.763, abs=0.02)
    assert np.polyval(parabola, 0.0) == pytest.approx(-0.57375, abs=1.5e-5)
    assert np.interp(6.763, times, along) == pytest.approx(-0.01890, abs=1.5e-5)


@pytest.mark.slow
@pytest.mark.parametrize("position_m", [None, 0.015])
def test_the_work_of_the_moment_is_stored_or_lost(position_m):
    setup = None if position_m is None else ContactSetup(radius_m=R, position_m=position_m)
    shares = []
    for step_s in (1e-3, 2.5e-4):
        by = Resolution(step_s=step_s)
        one = Simulation(driven(CURVED), setup, PULSES, resolution=by)
        one.advance(PULSES, np.array([1.0]))
        found = energy(one)
        shares.append(np.abs(found.imbalance).max() / np.abs(found.work).max())
    assert shares[0] < 1e-4
    assert shares[1] < 1e-5


@pytest.mark.slow
def test_without_loss_the_energy_of_a_release_stays():
    kept = []
    for step_s in (1e-3, 2.5e-4):
        by = Resolution(step_s=step_s, rho=1.0)
        one = Simulation(plain(), None, UNDRIVEN, released_from=under_tip_load(), resolution=by)
        one.advance(UNDRIVEN, np.array([1.0]))
        found = energy(one)
        kept.append(np.abs(found.imbalance).max() / found.elastic[0])
    assert kept[0] < 1e-3
    assert kept[1] < 1e-4


def test_straight_without_drive_nothing_moves():
    motion = simulate(plain(STRAIGHT), None, UNDRIVEN, np.array([0.0, 0.5]))
    assert np.all(motion.y_m == 0.0)
