"""A curve that leaves a strip is led on along it, by how the strip looks shortly before."""

import numpy as np
import pytest

from labrig.vision import Optics
from labrig.vision.curve.shape import make_basis, make_shape
from labrig.vision.fit.course import course_along
from labrig.vision.fit.leading_on import led_on_by_profile
from labrig.vision.image.image import read_grey_image

ROWS, COLUMNS, MIDDLE, BEGIN = 140, 260, 70, 20
THICK = 4.0
KNOWN = 120.0  # px from the clamp: up to here the strip is straight
BENDS_PX = 60.0  # and beyond that bends
OPTICS = Optics(px_per_mm=2.0, clamp_px=(float(BEGIN), float(MIDDLE)))


def picture(slope=0.8, light=100.0, end=200.0, noise=2.0):
    """A strip that is straight, then bends up to a slope; `light` over the ground, up to `end`."""
    columns, rows = np.meshgrid(np.arange(COLUMNS) - BEGIN, np.arange(ROWS) - MIDDLE)
    beyond = np.maximum(columns - KNOWN, 0.0) / BENDS_PX
    across = np.abs(rows + 0.5 * slope * BENDS_PX * beyond**2) / np.hypot(1, slope * beyond)
    share = np.clip(THICK / 2 - across + 0.5, 0, 1) * (columns < end)
    grey = 60 + light * share + np.random.default_rng(3).normal(0, noise, share.shape)
    return read_grey_image(np.clip(np.round(grey), 0, 255).astype(np.uint8), OPTICS)


def straight(length_px):
    basis = make_basis(length_px, length_px, 6, 1.0)
    return make_shape(basis, np.zeros(2), 0.0, np.zeros(basis.size))


def way_on(image):
    return led_on_by_profile(straight(180.0), KNOWN, [image], OPTICS, THICK)


@pytest.mark.parametrize("slope", [0.8, -0.8])
def test_the_strip_is_found_where_it_turns_aside(slope):
    image = picture(slope)
    assert course_along(straight(180.0), [image], OPTICS, THICK).end[0] < KNOWN + 6 * THICK
    way = way_on(image)
    assert way.s[-1] > KNOWN + 45
    drawn = slope * np.maximum(way.s - KNOWN, 0) / BENDS_PX
    assert np.abs(np.convolve(way.slope - drawn, np.ones(5) / 5, mode="valid")).max() < 0.15


def test_nothing_is_found_beyond_a_tip():
    assert way_on(picture(end=KNOWN)) is None


def test_noise_as_strong_as_the_strip_shows_no_way():
    assert way_on(picture(light=25.0, end=KNOWN, noise=20.0)) is None


def test_two_ways_that_look_alike_are_no_way():
    one, other = picture(0.8), picture(-0.8)
    both = np.maximum(one.grey, other.grey).astype(np.uint8)
    assert way_on(read_grey_image(both, OPTICS)) is None
