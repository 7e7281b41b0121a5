import datetime as dt

import numpy as np
import pytest

from drivers.load_cell import CalibrationError
from drivers.load_cell_fit import fit_calibration

WEIGHTS_N = np.array([0.0, 0.0098, 0.0196, 0.0392, 0.0588, 0.0785, 0.0981])
SLOPE, OFFSET, NOISE_V = 0.153, 1.7e-4, 4e-6


def test_weights_on_a_line_give_the_line():
    fit = fit_calibration(WEIGHTS_N, OFFSET + SLOPE * WEIGHTS_N)
    assert fit.sensitivity_V_per_N == pytest.approx(SLOPE)
    assert fit.offset_V == pytest.approx(OFFSET)
    assert np.abs(fit.residuals_N).max() < 1e-12


@pytest.mark.slow
def test_uncertainties_cover_the_truth_as_often_as_they_say():
    rng = np.random.default_rng(4)
    hits = np.zeros(2)
    trials = 2000
    for _ in range(trials):
        volts = OFFSET + SLOPE * WEIGHTS_N + rng.normal(0.0, NOISE_V, WEIGHTS_N.size)
        fit = fit_calibration(WEIGHTS_N, volts)
        hits += [
            abs(fit.sensitivity_V_per_N - SLOPE) < fit.sensitivity_sigma_V_per_N,
            abs(fit.offset_V - OFFSET) < fit.offset_sigma_V,
        ]
    # Binomial standard deviation over 2000 trials is 1 %; 3.5 of them either side.
    assert hits / trials == pytest.approx([0.683, 0.683], abs=0.036)


def test_a_known_noise_counts_where_few_weights_lie_on_a_line_by_chance():
    volts = OFFSET + SLOPE * WEIGHTS_N
    fit = fit_calibration(WEIGHTS_N, volts, volts_sigma_V=1e-5)
    spread = np.sqrt(np.sum((WEIGHTS_N - WEIGHTS_N.mean()) ** 2))
    assert fit.sensitivity_sigma_V_per_N == pytest.approx(1e-5 / spread)


def test_residuals_show_which_weight_is_wrong():
    volts = OFFSET + SLOPE * WEIGHTS_N
    volts[3] += SLOPE * 0.001  # 1 mN too much
    residuals = fit_calibration(WEIGHTS_N, volts).residuals_N
    assert np.argmax(np.abs(residuals)) == 3
    assert 0.0007 < residuals[3] < 0.001


def test_the_fit_becomes_a_dated_calibration():
    fit = fit_calibration(WEIGHTS_N, OFFSET + SLOPE * WEIGHTS_N, volts_sigma_V=1e-6)
    kept = fit.calibration(dt.date(2026, 5, 4), 0.0981, input_range_V=0.05, serial="GSO-10 1234")
    assert kept.date == dt.date(2026, 5, 4)
    assert kept.sensitivity_sigma_V_per_N == fit.sensitivity_sigma_V_per_N > 0.0
    assert float(kept.newtons(kept.volts(np.array(0.02)))) == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("loads", "volts", "says"),
    [
        ([0.0, 0.01], [0.0, 0.1], "at least three"),
        ([0.01, 0.01, 0.01], [0.1, 0.1, 0.1], "two different weights"),
        ([0.0, 0.01, 0.02], [0.0, 0.1], "3 weights but 2 voltages"),
        ([0.0, 0.01, 0.02], [0.0, np.nan, 0.2], "not a number"),
        ([0.0, 0.01, 0.02], [0.1, 0.1, 0.1], "does not follow the weights"),
        ([0.0, 0.01, 0.02], [0.1, 0.3, 0.1], "does not follow the weights"),
    ],
)
def test_weights_that_make_no_calibration_are_refused(loads, volts, says):
    with pytest.raises(CalibrationError, match=says):
        fit_calibration(loads, volts)
