"""Where the steps of a simulation end, and that those after a voltage edge are short enough."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import ModelError
from model.dynamics import ContactSetup, HeldVoltage, Resolution, simulate
from model.dynamics.motion.resolution import AFTER_EDGE_S, steps
from tests.model.dynamics.cases import R, driven

COARSE = Resolution(step_s=0.01, after_edges=2)
NONE = np.zeros(0)


def test_steps_end_at_all_times_and_edges():
    step_s, after = steps(0.0, np.array([0.1, 0.325]), np.array([0.202]), COARSE)
    ends = np.cumsum(step_s)
    assert ends[after - 1] == pytest.approx([0.1, 0.325])
    for end in (0.202, 0.202 + AFTER_EDGE_S):
        assert np.min(np.abs(ends - end)) < 1e-12
    begins = ends - step_s
    soon = (begins > 0.202 - 1e-9) & (begins < 0.302 - 1e-9)
    assert step_s[soon].max() <= 0.005 + 1e-12
    assert step_s[~soon].max() > 0.009


def test_an_edge_before_a_piece_counts_for_its_begin():
    step_s, _ = steps(1.0, np.array([1.04]), np.array([0.98]), COARSE)
    assert step_s == pytest.approx(np.full(8, 0.005))
    step_s, _ = steps(1.0, np.array([1.04]), np.array([0.5]), COARSE)
    assert step_s == pytest.approx(np.full(4, 0.01))


def test_times_that_are_the_same_have_no_step_between_them():
    step_s, after = steps(1.0, np.array([1.0]), NONE, COARSE)
    assert (len(step_s), after.tolist()) == (0, [0])
    step_s, after = steps(1.0, np.array([1.0, 1.01]), NONE, COARSE)
    assert (len(step_s), after.tolist()) == (1, [0, 1])


def test_no_step_can_be_made_longer_after_an_edge():
    with pytest.raises(ModelError, match="shorter by 1 or more"):
        Resolution(after_edges=0)


def test_pulses_in_contact_at_1_ms_are_within_a_thousandth_of_the_converged_force():
    drive = HeldVoltage(np.array([0.1, 0.7, 1.3]), np.array([2.0, -2.0, 0.0]))
    times = np.arange(0.0, 1.6, 1e-3)
    fine = Resolution(step_s=1.5e-4, degrees=(12, 6), line_terms=16, after_edges=1)
    usual = Resolution(step_s=1e-3)

    def force(by: Resolution) -> np.ndarray:
        setup = ContactSetup(radius_m=R, position_m=0.0)
        return simulate(driven(), setup, drive, times, s_m=NONE, resolution=by).force_N

    exact = force(fine)
    assert np.max(np.abs(force(usual) - exact)) < 1e-3 * np.ptp(exact)
    even = force(replace(usual, after_edges=1))
    assert np.max(np.abs(even - exact)) > 2e-3 * np.ptp(exact)  # why edges get shorter steps
