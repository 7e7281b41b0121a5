"""From a click to a fraction of a pixel."""

from __future__ import annotations

import numpy as np
import pytest

from labrig.errors import BadInputError
from labrig.panel.calibration.point_refinement import refine


def _drawn(inside, noise=2.0, seed=1):
    """A picture of 120 x 160, each pixel the share of it that is inside; 8 bit with noise."""
    fine = 8
    v, u = np.mgrid[0 : 120 * fine, 0 : 160 * fine]
    u, v = (u + 0.5) / fine - 0.5, (v + 0.5) / fine - 0.5
    share = inside(u, v).astype(float).reshape(120, fine, 160, fine).mean(axis=(1, 3))
    rng = np.random.default_rng(seed)
    return np.clip(40 + 150 * share + rng.normal(0, noise, share.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("click", [(80.0, 60.0), (77.0, 63.0), (83.5, 57.0)])
def test_a_corner_is_found_to_a_fifth_of_a_pixel(click):
    image = _drawn(lambda u, v: (u > 80.37) & (v + 0.2 * (u - 80.37) > 60.61))
    found = refine(image, click, "corner")
    assert np.hypot(found.px[0] - 80.37, found.px[1] - 60.61) < 0.2
    assert found.moved_px == pytest.approx(np.hypot(found.px[0] - click[0], found.px[1] - click[1]))


def test_the_crossing_of_a_checkerboard_is_found_to_a_twentieth_of_a_pixel():
    image = _drawn(lambda u, v: (u > 80.37) ^ (v > 60.61))
    found = refine(image, (78.0, 62.0), "corner")
    assert np.hypot(found.px[0] - 80.37, found.px[1] - 60.61) < 0.05


@pytest.mark.parametrize("bright", [True, False])
def test_the_middle_of_a_roll_is_found_to_a_twentieth_of_a_pixel(bright):
    def inside(u, v):
        disc = np.hypot(u - 80.37, v - 60.61) < 7.2
        return disc if bright else ~disc

    found = refine(_drawn(inside), (83.0, 58.0), "round")
    assert np.hypot(found.px[0] - 80.37, found.px[1] - 60.61) < 0.05


@pytest.mark.thorough
@pytest.mark.slow
def test_the_stated_uncertainty_covers_the_error_of_many_rolls():
    errors = []
    for seed in range(12):
        at = np.array([80.0, 60.0]) + np.random.default_rng(seed).uniform(-0.5, 0.5, 2)
        image = _drawn(lambda u, v, at=at: np.hypot(u - at[0], v - at[1]) < 6, 6.0, seed)
        found = refine(image, (81.0, 59.0), "round")
        errors.append(np.hypot(*(np.array(found.px) - at)) / found.sigma_px)
    assert np.mean(np.square(errors)) < 2 * 2.0  # two coordinates


def test_a_click_into_nothing_is_refused():
    with pytest.raises(BadInputError, match="stands out"):
        refine(_drawn(lambda u, v: u < -1), (80.0, 60.0), "corner")


def test_an_edge_alone_is_no_corner():
    with pytest.raises(BadInputError, match="edge"):
        refine(_drawn(lambda u, v: u > 80.3), (80.0, 60.0), "corner")


def test_a_click_at_the_very_edge_is_refused():
    with pytest.raises(BadInputError, match="too close"):
        refine(_drawn(lambda u, v: u > 80.3), (3.0, 60.0), "round")
