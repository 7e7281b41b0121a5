"""A motion beside a run, and its slow parameters, on motions with noise of `simulate`."""

from __future__ import annotations

import time

import numpy as np
import pytest

from model.dynamics import ContactSetup, simulate
from model.dynamics.online import GRID_S, Estimate, GridMotion, RunEstimator
from model.dynamics.online.grid_motion import Drive, scaled
from tests.cases import few
from tests.model.dynamics.sheets import RADIUS_M, beam

PULSE_S, PULSES, END_S = 0.6, (2.0, -2.0, 0.0, 2.0, -2.0, 0.0, 2.0, -2.0, 0.0), 6.0
ROLLS = ContactSetup(radius_m=RADIUS_M, position_m=0.01)


def drive():
    found = Drive()
    for k, volts in enumerate(PULSES):
        found.add(0.5 + PULSE_S * k, volts)
    return found


def recorded(sheet, rolls=ROLLS, seed=1, drift_N=3e-5):
    """Means of 0.1 s of the force, and curves: (time, force or None, curve or None)."""
    dice = np.random.default_rng(seed)
    t = np.arange(0.0, END_S, 1e-3)
    motion = simulate(sheet, rolls, drive().until(END_S), t, s_m=np.linspace(0, 0.05, 60))
    force = motion.reading_N + dice.normal(0, 1e-4, len(t)) + 2e-4
    force += drift_N * np.sin(2 * np.pi * t / 5.0)
    rows = []
    for k in range(60):
        rows.append((0.1 * k + 0.0495, float(force[100 * k : 100 * k + 100].mean()), None))
        if k % 2:
            at = 100 * k + 70
            curve = np.stack([motion.x_m[at], motion.y_m[at]], axis=1)
            rows.append((0.1 * k + 0.07, None, curve + dice.normal(0, 3e-5, (60, 1))))
    return rows


def estimated(sheet, rows, rolls=ROLLS, prior=None):
    found = RunEstimator(sheet, rolls, prior or Estimate.unknown())
    made = drive()
    for time_s, force_N, curve in rows:
        if force_N is not None:
            found.add_force(made, time_s, force_N, 1e-5)
        if curve is not None:
            found.add_curve(made, time_s, curve)
    return found.estimate


def test_the_motion_beside_a_run_is_that_of_simulate():
    made, sheet = drive(), beam()
    motion = GridMotion(sheet, ROLLS)
    for until_s in np.arange(0.0, 2.0, 0.033):
        motion.advance(made, float(until_s))
    times = GRID_S * np.arange(motion.count)
    whole = simulate(sheet, ROLLS, made.until(END_S), times)
    np.testing.assert_allclose(motion.force_N(), whole.reading_N, atol=1e-8)
    np.testing.assert_allclose(motion.current_A(100), whole.current_A[100:], atol=1e-9)
    shape = motion.shape_at(times[-1])
    np.testing.assert_allclose(shape, np.stack([whole.x_m[-1], whole.y_m[-1]], axis=1), atol=1e-7)
    assert motion.shape_at(motion.time_s + 0.1) is None


def test_a_voltage_that_is_not_written_yet_is_not_known():
    made = Drive()
    assert made.until(3.0).at(np.array([1.0])) == [0.0]
    made.add(1.0, 2.0)
    made.add(1.0, 1.5)
    np.testing.assert_array_equal(made.until(3.0).at(np.array([0.5, 2.0])), [0.0, 1.5])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "moment"),
    few(
        [
            (1.0, 1.0),
            (1.25, 0.9),
            *(
                pytest.param(*pair, marks=pytest.mark.thorough)
                for pair in ((1.2, 1.0), (0.8, 1.0), (1.0, 0.85))
            ),
        ]
    ),
)
def test_stiffness_and_moment_of_the_sheet_are_found_with_a_model_that_is_off(stiffness, moment):
    rows = recorded(beam())
    found = estimated(scaled(beam(), stiffness, moment), rows)
    truth = 1 / stiffness, 1 / moment
    for ratio, sigma, true in zip(found.ratios, found.sigmas, truth, strict=True):
        assert abs(ratio - true) < max(3 * sigma, 0.01)
        assert sigma < 0.03


@pytest.mark.thorough
def test_the_intervals_hold_the_truth_as_often_as_they_should():
    off = np.empty(0)
    for seed in range(6):
        found = estimated(scaled(beam(), 1.1, 1.0), recorded(beam(), seed=seed))
        off = np.append(off, (np.array(found.ratios) - (1 / 1.1, 1.0)) / found.sigmas)
    assert np.sqrt(np.mean(np.square(off))) < 2.0


@pytest.mark.slow
def test_the_force_alone_leaves_the_stiffness_open():
    rows = [(t, force, None) for t, force, _ in recorded(beam())]
    found = estimated(beam(), rows)
    assert found.sigmas[0] > 3 * found.sigmas[1]


@pytest.mark.slow
def test_a_free_sheet_shows_the_ratio_of_both():
    rows = [(t, None, curve) for t, _, curve in recorded(beam(), rolls=None)]
    found = estimated(scaled(beam(), 1.2, 1.0), rows, rolls=None)
    stiffness, moment = found.ratios
    assert moment / stiffness == pytest.approx(1.2, abs=0.03)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_sheet_that_dries_from_run_to_run_is_followed():
    estimate, seen = Estimate.unknown(), []
    for run in range(4):
        sheet = scaled(beam(), 1.0 + 0.04 * run, 1.0 - 0.02 * run)
        estimate = estimated(beam(), recorded(sheet, seed=run), prior=estimate.after(30.0))
        seen.append(estimate.ratios)
    stiffness, moment = np.array(seen).T
    np.testing.assert_allclose(stiffness, 1.0 + 0.04 * np.arange(4), atol=0.03)
    np.testing.assert_allclose(moment, 1.0 - 0.02 * np.arange(4), atol=0.02)


def test_what_is_not_a_number_changes_nothing():
    found, made = RunEstimator(beam(), ROLLS, Estimate.unknown()), drive()
    found.add_force(made, 0.1, float("nan"), 1e-5)
    found.add_curve(made, 0.1, np.full((5, 2), np.nan))
    assert found.estimate.ratios == (1.0, 1.0)


def test_a_second_of_all_four_motions_takes_a_small_part_of_one():
    made = drive()
    motions = [GridMotion(beam(), ROLLS) for _ in range(4)]
    for motion in motions:
        motion.advance(made, 0.5)
    began_s = time.process_time()
    for until_s in 0.5 + 0.04 * np.arange(1, 26):
        for motion in motions:
            motion.advance(made, float(until_s))
    assert time.process_time() - began_s < 0.2
