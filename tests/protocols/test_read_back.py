"""A voltage that nobody sees, or that stays, ends the session before anybody is asked to act."""

from __future__ import annotations

import numpy as np
import pytest

from drivers.interfaces import DeviceError, OvervoltageError
from labrig.testing.fake_rig import FakeRig, short_schedule
from protocols.execution.events import Outcome, OutputState
from protocols.execution.rules import Rules
from protocols.execution.runs.read_back import ReadBack

EVERY_S = 0.025
NAN = float("nan")


def looked(*courses, rate_hz=1000.0):
    """What becomes of (volts written, volts read back, for so many s), one after the other."""
    read_back, now_s, zero_s = ReadBack(Rules(), 2.5, rate_hz, 0.0), 0.0, None
    for written_V, seen_V, for_s in courses:
        zero_s = (now_s if zero_s is None else zero_s) if written_V == 0.0 else None
        for _ in range(round(for_s / EVERY_S)):
            now_s += EVERY_S
            samples = np.full(round(rate_hz * EVERY_S), seen_V)
            read_back.take(samples, now_s, 0.0 if zero_s is None else now_s - zero_s)
    return read_back


def test_0_v_is_shown_where_it_was_written_and_seen():
    assert looked((0.0, 0.01, 0.1)).shows_zero
    assert not looked((0.0, 0.01, 0.1), (2.0, 2.0, 0.1)).shows_zero
    assert looked((2.0, 2.0, 0.1), (0.0, 0.3, 0.3), (0.0, 0.01, 0.1)).shows_zero
    assert not looked((0.0, 0.1, 0.4)).shows_zero
    assert not looked((0.0, NAN, 0.4)).shows_zero


def test_what_was_seen_before_a_pulse_says_nothing_after_it():
    assert not looked((0.0, 0.0, 0.3), (0.1, 0.1, 0.3), (0.0, 0.1, 0.3)).shows_zero


@pytest.mark.parametrize("stays_V", [0.06, -0.06, 0.19, 0.3, 2.0])
def test_a_voltage_that_stays_ends_the_run_half_a_second_later(stays_V):
    looked((stays_V, stays_V, 1.0), (0.0, stays_V, 0.5))
    with pytest.raises(OvervoltageError, match=r"0 V was written 0\.\d s ago"):
        looked((stays_V, stays_V, 1.0), (0.0, stays_V, 0.6))


def test_a_voltage_that_comes_again_at_0_v_ends_the_run_where_it_is_no_error_of_the_amplifier():
    looked((0.0, 0.0, 1.0), (0.0, 0.15, 1.0))
    with pytest.raises(OvervoltageError):
        looked((0.0, 0.0, 1.0), (0.0, 0.25, 1.0))


def test_an_amplifier_that_jumps_when_its_supply_returns_is_given_its_time():
    read_back = ReadBack(Rules(), 2.5, 1000.0, 100.0)
    for k, volts in enumerate([0.15] * 10 + [0.01] * 40):  # 0 V was written long ago
        read_back.take(np.full(25, volts), 100.0 + EVERY_S * (k + 1), 60.0)
    assert read_back.shows_zero


@pytest.mark.parametrize("written_V", [0.0, 2.0])
def test_a_read_back_that_is_no_number_for_half_a_second_ends_the_run(written_V):
    looked((written_V, written_V, 1.0), (written_V, NAN, 0.4), (written_V, written_V, 1.0))
    with pytest.raises(DeviceError, match="nobody sees which voltage the sheet has"):
        looked((written_V, written_V, 1.0), (written_V, NAN, 0.6))


def test_single_samples_that_are_no_numbers_hide_nothing():
    read_back = ReadBack(Rules(), 2.5, 1000.0, 0.0)
    samples = np.full(25, 0.01)
    samples[::3] = NAN
    for k in range(1, 80):
        read_back.take(samples, EVERY_S * k, EVERY_S * k)
    assert read_back.shows_zero


@pytest.mark.slow
@pytest.mark.parametrize("noise_V", [1e-3, 5e-3, 20e-3])
def test_noise_of_the_read_back_is_no_voltage_that_stays(noise_V):
    random = np.random.default_rng(5)
    read_back = ReadBack(Rules(), 2.5, 1000.0, 0.0)
    for k in range(1, 4000):  # 100 s
        volts = 0.01 + noise_V * random.standard_normal(25)
        read_back.take(volts, EVERY_S * k, EVERY_S * k)
    assert read_back.shows_zero


def session(spoil):
    rig = FakeRig()
    rig.signals.spoil = lambda times_s, volts: spoil(rig, times_s, volts[2])
    scheduler = rig.scheduler()
    return rig, scheduler.run(short_schedule(0.0, 0.005))


def stays(rig, times_s, drive_V):
    """A voltage of 0.1 V stays once there was one."""
    if any(volts for _, volts in rig.output.writes):
        drive_V[drive_V == 0.0] = 0.1


def blind(rig, times_s, drive_V):
    if any(volts for _, volts in rig.output.writes):
        drive_V[:] = NAN


@pytest.mark.parametrize(
    ("spoil", "why"),
    [(stays, "the drive still reads back 0.1 V"), (blind, "nobody sees which voltage")],
)
def test_nobody_is_asked_to_move_the_load_cell_then(spoil, why):
    rig, outcome = session(spoil)
    assert outcome is Outcome.FAILED
    assert rig.events[-1].output is OutputState.UNKNOWN
    assert why in rig.events[-1].reason
    assert len(rig.stage.moves) == 1
    assert rig.output.last_V == 0.0
