"""The figure of a measured and simulated motion, and its errors."""

from __future__ import annotations

import numpy as np
import pytest

from labrig.report.figures.motion import MotionComparison, compared, motion_figure
from model.dynamics import ContactSetup, HeldVoltage, simulate
from model.dynamics.identification import RecordedRun, RunPlan
from tests.labrig.moving_model import model

DRIVE = HeldVoltage(np.array([-5.0, 0.5, 1.1]), np.array([0.01, 2.01, 0.01]))
SAMPLES, FRAMES = np.arange(0.0, 2.0, 1e-3), np.arange(0.02, 2.0, 0.04)
POINTS = np.array([0.01, 0.03, 0.049])


def recorded(position_m: float | None, noise: float) -> RecordedRun:
    """What the model itself says, with a little more force, current and height."""
    setup = None if position_m is None else ContactSetup(radius_m=0.04, position_m=position_m)
    frames = position_m is None
    plan = RunPlan(
        drive=DRIVE,
        time_s=SAMPLES,
        setup=setup,
        force=setup is not None,
        frame_s=FRAMES if frames else np.zeros(0),
        points_m=POINTS if frames else np.zeros(0),
    )
    beam, _ = model().moving("long", None)
    at_samples = simulate(beam, setup, DRIVE, SAMPLES)
    at_frames = simulate(beam, setup, DRIVE, FRAMES, s_m=POINTS)
    return RecordedRun(
        plan=plan,
        force_N=at_samples.force_N + noise * 1e-3 if setup else None,
        current_A=at_samples.current_A + noise * 2e-3,
        x_m=at_frames.x_m if frames else None,
        y_m=at_frames.y_m + noise * 3e-3 if frames else None,
    )


@pytest.fixture(scope="module")
def pair() -> tuple[MotionComparison, MotionComparison]:
    beam, _ = model().moving("long", None)
    return compared(beam, recorded(0.005, 1.0)), compared(beam, recorded(None, 1.0))


@pytest.mark.slow
def test_errors_are_those_that_were_added(pair: tuple[MotionComparison, MotionComparison]) -> None:
    held, free = pair
    assert held.force_rms_N == pytest.approx(1e-3, rel=1e-3)
    assert held.current_rms_A == pytest.approx(2e-3, rel=1e-3)
    assert np.isnan(held.tip_rms_m)
    assert np.isnan(free.force_rms_N)
    assert free.tip_rms_m == pytest.approx(3e-3, rel=1e-3)


def test_the_pulse_is_that_of_the_voltage_not_of_the_offset(
    pair: tuple[MotionComparison, MotionComparison],
) -> None:
    assert pair[0].pulse_s() == (0.5, 1.1)


def test_the_figure_shows_both_beside_each_other_from_the_voltage_on(
    pair: tuple[MotionComparison, MotionComparison],
) -> None:
    fig = motion_figure(*pair)
    force, current, tip = fig.axes
    assert [len(axes.lines) for axes in (force, current, tip)] == [2, 2, 4]
    for axes in (force, current):
        measured, simulated = axes.lines
        assert measured.get_xdata()[0] == pytest.approx(-0.1)
        assert simulated.get_xdata()[-1] == pytest.approx(0.9)
    gap = force.lines[0].get_ydata() - np.interp(
        force.lines[0].get_xdata(), *force.lines[1].get_data()
    )
    assert gap == pytest.approx(1.0, abs=1e-6)  # mN
    assert tip.lines[2].get_xdata()[-1] > 1.2  # its swing, too
