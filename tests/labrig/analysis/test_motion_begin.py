"""What is told of a recorded motion before it is fitted: its swing, a current without a wire."""

from __future__ import annotations

import numpy as np
import pytest

from labrig.analysis.motion.beginning import swing_hz
from labrig.analysis.motion.silent_current import follows_the_voltage
from model.dynamics import ElectrodeLine, HeldVoltage, LineModes
from model.dynamics.identification import RecordedRun, RunPlan

LINE = ElectrodeLine(
    electrode_ohm_per_m=4000.0, capacitance_F_per_m=0.3, bulk_ohm_m=0.5, leak_S_per_m=0.1
)
PULSES = HeldVoltage(np.array([0.5, 1.1, 1.7]), np.array([1.0, -1.0, 0.0]))
TIME_S = np.arange(2300) * 1e-3


def swinging(hz: float, frames_hz: float) -> RecordedRun:
    """A free sheet after 0 V, its tip on a decaying sine, a creep and 0.02 mm of noise."""
    drive = HeldVoltage(np.array([0.2, 0.8]), np.array([1.0, 0.0]))
    frame_s = np.arange(0.0, 3.0, 1.0 / frames_hz)
    since_s = np.maximum(0.0, frame_s - 0.8)
    tip = 4e-3 * np.exp(-since_s) * np.cos(2.0 * np.pi * hz * since_s) + 2e-3 * np.exp(-since_s)
    tip += 2e-5 * np.random.default_rng(3).standard_normal(len(tip))
    plan = RunPlan(
        drive=drive, time_s=np.zeros(0), force=False, current=False, frame_s=frame_s,
        points_m=np.array([0.05]),
    )  # fmt: skip
    return RecordedRun(plan=plan, x_m=np.full((len(tip), 1), 0.04), y_m=tip[:, None])


@pytest.mark.parametrize(("hz", "frames_hz"), [(3.3, 25.0), (6.8, 25.0), (3.3, 10.0), (2.1, 8.0)])
def test_a_swing_is_not_taken_for_a_faster_one_that_few_frames_show_alike(hz, frames_hz):
    assert swing_hz(swinging(hz, frames_hz)) == pytest.approx(hz, rel=0.03)


def of_a_sheet(drive: HeldVoltage) -> np.ndarray:
    line = LineModes(LINE, 0.05, 10)
    held = drive.at(TIME_S + 5e-4)
    modes = line.respond(np.zeros(10), np.full(len(TIME_S), 1e-3), held)[1:]
    return line.current_A(modes, held)


def of_an_open_input(drive: HeldVoltage) -> np.ndarray:
    """Noise, hum, and a drift."""
    noise = np.random.default_rng(5).normal(0.0, 5e-5, len(TIME_S))
    return noise + 1e-3 * np.sin(2.0 * np.pi * 50.0 * TIME_S + 0.3) + 2e-5 * TIME_S


def test_a_sheets_current_follows_the_voltage_and_that_of_an_open_input_does_not():
    assert follows_the_voltage(PULSES, TIME_S, of_a_sheet(PULSES))
    noisy = of_a_sheet(PULSES) + of_an_open_input(PULSES)
    assert follows_the_voltage(PULSES, TIME_S, noisy)
    assert not follows_the_voltage(PULSES, TIME_S, of_an_open_input(PULSES))


def test_nothing_is_said_of_a_run_without_a_voltage_or_with_few_samples():
    still = HeldVoltage(np.zeros(1), np.zeros(1))
    assert follows_the_voltage(still, TIME_S, of_an_open_input(still))
    assert follows_the_voltage(PULSES, TIME_S[:100], of_an_open_input(PULSES)[:100])
