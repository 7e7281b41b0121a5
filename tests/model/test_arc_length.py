"""Arc length of measured points, against curves whose length is known."""

from __future__ import annotations

import numpy as np
import pytest

from model.measurements.arc_length import arc_length_m


def bent(s, k1_per_m=40.0):
    """A sheet whose curvature falls along it."""
    fine = np.linspace(0.0, s[-1], 50001)
    phi = k1_per_m * 0.02 * (1.0 - np.exp(-fine / 0.02))
    step = fine[1]
    along = (
        np.concatenate([[0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * step)])
        for f in (np.cos(phi), np.sin(phi))
    )
    return tuple(np.interp(s, fine, one) for one in along)


def test_arc_length_is_that_of_the_curve_not_of_its_chords():
    angle = np.linspace(0, 4, 41)  # 230 degrees of a circle of 12.5 mm, 1.25 mm apart
    x, y = 0.0125 * np.sin(angle), 0.0125 * (1 - np.cos(angle))
    np.testing.assert_allclose(arc_length_m(x, y), 0.0125 * angle, rtol=1e-12)
    s = np.linspace(0, 0.05, 51)
    phi = 24 * 0.04 * (1 - np.exp(-s / 0.04))
    fine = np.linspace(0, 0.05, 50001)
    fine_phi = 24 * 0.04 * (1 - np.exp(-fine / 0.04))
    x, y = (
        np.interp(s, fine, np.concatenate([[0], np.cumsum(0.5 * (f[1:] + f[:-1]) * 1e-6)]))
        for f in (np.cos(fine_phi), np.sin(fine_phi))
    )
    assert phi[-1] > 0.6
    np.testing.assert_allclose(arc_length_m(x, y), s, atol=2e-9)


@pytest.mark.parametrize("count", [20, 101, 500])
@pytest.mark.parametrize("noise_m", [2e-5, 2e-4])
def test_noise_does_not_lengthen_a_curve(count, noise_m):
    """Of 500 points 0.1 mm apart the chords are three times as long as the sheet."""
    random = np.random.default_rng(count)
    s = np.linspace(0.0, 0.05, count)
    x, y = bent(s)
    lengths = []
    for _ in range(20):
        noisy = (p + noise_m * random.standard_normal(count) for p in (x, y))
        found = arc_length_m(*noisy)
        assert np.all(np.diff(found) > 0.0)
        lengths.append(found[-1])
    # two ends are as uncertain as their points
    away = np.mean(lengths) - 0.05
    assert abs(away) < 1.5 * noise_m
    assert np.std(lengths) < 4.0 * noise_m


def test_a_line_of_pixels_is_as_long_as_the_sheet():
    s = np.linspace(0.0, 0.05, 2000)
    pixel_m = 1e-4
    pixels = np.unique(np.round(np.stack(bent(s)) / pixel_m).T, axis=0) * pixel_m  # x ascends
    chords = np.hypot(*np.diff(pixels, axis=0).T).sum()
    assert chords > 1.04 * 0.05
    assert arc_length_m(*pixels.T)[-1] == pytest.approx(0.05, rel=0.005)


def test_a_corner_is_not_rounded_off():
    s = np.linspace(0.0, 0.05, 101)
    x, y = np.minimum(s, 0.02), np.maximum(s - 0.02, 0.0)
    random = np.random.default_rng(0)
    noisy = (p + 2e-5 * random.standard_normal(101) for p in (x, y))
    assert arc_length_m(*noisy)[-1] == pytest.approx(0.05, rel=0.005)
