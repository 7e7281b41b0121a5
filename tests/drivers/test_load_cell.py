import datetime as dt

import numpy as np
import pytest

from drivers.interfaces import OverloadError
from drivers.load_cell import (
    CalibrationError,
    LoadCell,
    LoadCellCalibration,
    LoadState,
)

CAPACITY_N = 0.0980665
DIRECT = LoadCellCalibration(  # 1.5 mV/V at 10 V, straight into the board
    date=dt.date(2026, 3, 1),
    capacity_N=CAPACITY_N,
    sensitivity_V_per_N=0.015 / CAPACITY_N,
    offset_V=2e-4,
    sensitivity_sigma_V_per_N=1e-4,
    offset_sigma_V=1e-6,
    input_range_V=0.05,
)


def volts(force_N: float, samples: int = 50) -> np.ndarray:
    return np.full(samples, float(DIRECT.volts(np.array(force_N))))


def test_volts_and_newtons_are_each_others_reverse():
    forces = np.linspace(-0.1, 0.1, 7)
    assert DIRECT.newtons(DIRECT.volts(forces)) == pytest.approx(forces, abs=1e-15)


def test_a_tare_is_taken_off_and_can_be_put_back():
    cell = LoadCell(DIRECT)
    assert cell.tare(volts(0.004)) == pytest.approx(0.004)
    assert cell.newtons(volts(0.010))[0] == pytest.approx(0.006)
    cell.untare()
    assert cell.newtons(volts(0.010))[0] == pytest.approx(0.010)


@pytest.mark.parametrize("bad", [np.array([]), np.array([0.0, np.nan])])
def test_taring_without_valid_samples_is_refused(bad):
    with pytest.raises(CalibrationError, match="tare"):
        LoadCell(DIRECT).tare(bad)


@pytest.mark.parametrize(
    ("share", "state"),
    [
        (0.0, LoadState.FINE),
        (0.99, LoadState.FINE),
        (1.01, LoadState.ABOVE_CAPACITY),
        (-1.1, LoadState.ABOVE_CAPACITY),
        (1.19, LoadState.ABOVE_CAPACITY),
        (1.21, LoadState.OVERLOAD),
        (-1.21, LoadState.OVERLOAD),
    ],
)
def test_the_load_is_judged_against_the_capacity(share, state):
    check = LoadCell(DIRECT).check(volts(share * CAPACITY_N))
    assert check.state is state
    assert check.peak_N == pytest.approx(share * CAPACITY_N)
    assert (check.text == "") == (state is LoadState.FINE)


def test_a_tare_does_not_hide_an_overload():
    cell = LoadCell(DIRECT)
    cell.tare(volts(0.5 * CAPACITY_N))
    with pytest.raises(OverloadError, match="125% of its capacity"):
        cell.protect(volts(1.25 * CAPACITY_N))


def test_two_glitched_samples_are_no_overload_but_three_are():
    samples = volts(0.01)
    samples[[10, 30]] = 0.045
    assert LoadCell(DIRECT).protect(samples).state is LoadState.FINE
    samples[20] = 0.045
    with pytest.raises(OverloadError):
        LoadCell(DIRECT).protect(samples)


def test_the_end_of_a_small_input_range_is_told_apart_from_an_overload():
    amplified = LoadCellCalibration(
        date=DIRECT.date,
        capacity_N=CAPACITY_N,
        sensitivity_V_per_N=10.0 / CAPACITY_N,  # a conditioner: capacity is the end of ±10 V
        offset_V=0.5,
        gain=667.0,
    )
    check = LoadCell(amplified, input_range=10.0).protect(np.full(50, 10.0))
    assert check.state is LoadState.SATURATED
    assert "±10 V" in check.text
    assert "larger range" in check.text


def test_a_rail_beyond_the_overload_limit_trips_and_names_the_other_possible_cause():
    with pytest.raises(OverloadError, match="broken wire or missing excitation"):
        LoadCell(DIRECT).protect(np.full(50, 0.05))


def test_a_signal_that_is_not_a_number_trips():
    with pytest.raises(OverloadError, match="no numbers"):
        LoadCell(DIRECT).protect(np.array([0.0, np.nan, 0.0]))


def test_no_samples_say_nothing():
    assert LoadCell(DIRECT).check(np.array([])).state is LoadState.FINE


def test_uncertainty_of_a_force_has_a_part_from_offset_and_one_from_slope():
    assert DIRECT.sigma_N(0.0) == pytest.approx(1e-6 / DIRECT.sensitivity_V_per_N)
    assert DIRECT.sigma_N(0.05) == pytest.approx(
        np.hypot(1e-6, 0.05 * 1e-4) / DIRECT.sensitivity_V_per_N
    )


@pytest.mark.parametrize(
    ("key", "value"),
    [("capacity_N", 0.0), ("sensitivity_V_per_N", 0.0), ("offset_V", float("nan")),
     ("sensitivity_sigma_V_per_N", -1.0), ("input_range_V", float("inf"))],
)  # fmt: skip
def test_a_calibration_that_cannot_be_is_refused(key, value):
    good = {
        "date": DIRECT.date,
        "capacity_N": CAPACITY_N,
        "sensitivity_V_per_N": 0.15,
        "offset_V": 0.0,
    }
    with pytest.raises(CalibrationError, match=key):
        LoadCellCalibration(**{**good, key: value})
