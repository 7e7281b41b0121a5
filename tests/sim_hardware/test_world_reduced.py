"""Sessions without pixels and volts."""

from __future__ import annotations

import time

import numpy as np
import pytest

from sim_hardware.world import CurveErrors, load_world, reduced_session


def test_a_session_holds_every_condition_with_its_readings_and_curve() -> None:
    session = reduced_session(load_world(), seed=3)
    assert len(session.conditions) == 2 * 7 * 3
    for c in session.conditions:
        assert c.forces_N.shape == (10,)
        assert c.s_m.shape == c.x_m.shape == c.y_m.shape
        assert c.s_m[1] - c.s_m[0] == pytest.approx(0.5e-3, rel=0.01)
        assert np.mean(c.forces_N) == pytest.approx(c.true_force_N, abs=0.1e-3)
    spread = np.concatenate([c.forces_N - c.true_force_N for c in session.conditions])
    assert 0.02e-3 < np.std(spread) < 0.05e-3


@pytest.mark.slow
def test_the_curve_errors_are_as_stated() -> None:
    errors = CurveErrors(white_m=1e-6, smooth_m=3e-6)
    settings = load_world()
    exact = reduced_session(settings, 1, curve_errors=CurveErrors(0.0, 0.0))
    noisy = reduced_session(settings, 1, curve_errors=errors)
    off = np.concatenate(
        [
            np.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
            for a, b in zip(exact.conditions, noisy.conditions, strict=True)
        ]
    )
    assert np.sqrt(np.mean(off**2)) == pytest.approx(errors.sigma_m, rel=0.1)
    assert noisy.conditions[0].curve_sigma_m == errors.sigma_m
    for c in exact.conditions:
        assert (c.x_m[0], c.y_m[0]) == (0.0, 0.0)


@pytest.mark.slow
def test_the_truth_is_the_world_s_without_scatter() -> None:
    settings = load_world()
    sessions = [reduced_session(settings, seed) for seed in range(6)]
    first = sessions[0]
    assert first.B_Nm2["long"] == settings.configurations["long"].stiffness_Nm2
    offset_V = settings.amplifier.gain * settings.amplifier.offset_mV * 1e-3
    for (name, voltage), found in first.mean_eibm_Nm.items():
        chosen = [c for c in first.conditions if (c.configuration, c.voltage_V) == (name, voltage)]
        l_hat_mm = np.array([c.true_l_hat_m for c in chosen]) * 1e3
        mean = np.mean(100 * 12 / l_hat_mm * (1 - np.exp(-l_hat_mm / 12)))
        share = settings.eibm.settled(voltage + offset_V)
        assert found == pytest.approx(mean * share * first.B_Nm2[name], rel=1e-5)
    shares = [c.true_B_Nm2 / s.B_Nm2[c.configuration] for s in sessions for c in s.conditions[::3]]
    assert np.mean(shares) == pytest.approx(1.0, abs=0.004)
    assert np.std(shares) == pytest.approx(0.01, rel=0.3)


def test_the_truth_satisfies_the_mean_moment_balance() -> None:
    # (2): phi_hat = int k0 + l_hat (mean Me + mean M) / B, with the curve of the session itself.
    settings = load_world()
    session = reduced_session(settings, 2, curve_errors=CurveErrors(0.0, 0.0))
    for c in session.conditions:
        if c.configuration != "long" or c.position_m is None:
            continue
        # From the curve: mean direction of the links around s_hat, and the centre of [0, l_hat].
        fine = np.linspace(0, c.true_l_hat_m, 4001)
        x, y = np.interp(fine, c.s_m, c.x_m), np.interp(fine, c.s_m, c.y_m)
        hat = np.searchsorted(c.s_m, c.true_l_hat_m)
        dx, dy = np.diff(c.x_m), np.diff(c.y_m)
        angles = np.unwrap(np.arctan2(dy, dx))
        middles = (c.s_m[1:] + c.s_m[:-1]) / 2
        phi_hat = np.interp(c.true_l_hat_m, middles[: hat + 2], angles[: hat + 2])
        beta = np.arctan2(y[-1], x[-1])
        N = c.true_force_N / np.cos(phi_hat - beta)
        force = -N * np.array([-np.sin(phi_hat), np.cos(phi_hat)])
        arm = np.array([x[-1] - x.mean(), y[-1] - y.mean()])
        mean_M = arm[0] * force[1] - arm[1] * force[0]
        rest = 24 * 0.04 * (1 - np.exp(-c.true_l_hat_m / 0.04))
        turned = rest + c.true_l_hat_m * (c.true_mean_eibm_Nm + mean_M) / c.true_B_Nm2
        assert phi_hat == pytest.approx(turned, abs=1e-3)


def test_free_shapes_and_other_voltages_can_be_asked_for() -> None:
    session = reduced_session(
        load_world(), 1, configurations=("short",), positions_m=(None, 0.01), voltages=(1.0,)
    )
    free, held = session.conditions
    assert free.position_m is None
    assert free.forces_N.size == 0
    assert held.forces_N.size == 10
    assert free.y_m[-1] > held.y_m[-1] - 0.02


def test_a_position_out_of_reach_is_left_out() -> None:
    session = reduced_session(
        load_world(), 1, configurations=("long",), positions_m=(0.0, 0.06), voltages=(0.0,)
    )
    assert [c.position_m for c in session.conditions] == [0.0]


@pytest.mark.slow
def test_the_same_seed_gives_the_same_session_and_it_takes_milliseconds() -> None:
    settings = load_world()
    first = reduced_session(settings, 5)
    began = time.perf_counter()
    again = reduced_session(settings, 5)
    assert time.perf_counter() - began < 1.0
    other = reduced_session(settings, 6)
    for a, b, c in zip(first.conditions, again.conditions, other.conditions, strict=True):
        assert np.array_equal(a.forces_N, b.forces_N)
        assert np.array_equal(a.y_m, b.y_m)
        assert not np.array_equal(a.forces_N, c.forces_N)
