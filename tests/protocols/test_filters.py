"""The symmetric filter."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.execution.filters import symmetric_mean, window

INDEX = np.arange(1000.0)


@pytest.mark.slow
@given(
    centre=st.floats(400.0, 600.0),
    half_window=st.floats(0.0, 300.0),
    level=st.floats(-10.0, 10.0),
    slope=st.floats(-1.0, 1.0),
)
def test_a_linear_trend_leaves_the_value_at_the_centre_unbiased(centre, half_window, level, slope):
    found = symmetric_mean(level + slope * INDEX, centre, half_window).value
    assert found == pytest.approx(level + slope * centre, abs=1e-9, rel=1e-12)


@pytest.mark.slow
@given(centre=st.floats(400.0, 600.0), half_window=st.floats(3.0, 300.0))
def test_samples_outside_the_window_have_no_say(centre, half_window):
    signal = np.where(np.abs(INDEX - centre) < half_window, 1.0, np.nan)
    assert symmetric_mean(signal, centre, half_window).value == pytest.approx(1.0)


@pytest.mark.slow
def test_the_noise_factor_is_that_of_white_noise():
    samples = np.random.default_rng(1).normal(size=(20_000, 201))
    found = symmetric_mean(samples, 100.3, 80.0)
    assert np.std(found.value) == pytest.approx(found.noise_factor, rel=0.02)
    # Of a Hann window of n samples it is sqrt(1.5 / n).
    assert found.noise_factor == pytest.approx(np.sqrt(1.5 / 160.0), rel=1e-3)


def test_a_hum_whose_periods_fill_the_window_is_suppressed():
    hum = np.sin(2 * np.pi * 50e-3 * INDEX + 0.7)  # 50 Hz at 1 kHz, five periods a half window
    assert abs(symmetric_mean(hum, 500.37, 100.0).value) < 1e-3


def test_several_signals_are_filtered_at_once():
    found = symmetric_mean(np.stack([INDEX, -INDEX]), 500.25, 10.0)
    assert found.value == pytest.approx([500.25, -500.25])


@pytest.mark.parametrize(("centre", "half_window"), [(5.0, 10.0), (995.0, 10.0), (-3.0, 0.0)])
def test_a_window_beyond_the_samples_is_an_error(centre, half_window):
    with pytest.raises(ValueError, match="the filter needs samples"):
        symmetric_mean(INDEX, centre, half_window)


@pytest.mark.parametrize(
    ("centre", "half_window", "expected"),
    [(10.0, 3.0, (8, 12)), (10.5, 3.0, (8, 13)), (10.0, 0.0, (10, 10)), (10.25, 0.5, (10, 11))],
)
def test_a_window_holds_the_samples_whose_weight_is_not_zero(centre, half_window, expected):
    assert window(centre, half_window) == expected
