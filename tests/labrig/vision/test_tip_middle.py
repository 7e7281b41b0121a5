"""The middle of a tip that is cut askew or bent aside is measured by its outline."""

import numpy as np
import pytest

from labrig.vision.extraction.tip_middle import tip_middle_px
from labrig.vision.fit.stated_places import StatedPlaces
from tests.labrig.vision.test_strip_end import BEGIN, COLUMNS, MIDDLE, OPTICS, ROWS, grey, straight

THICK, END = 20.0, 160


def bent_tip(aside_px, contrast=80.0, noise=2.0):
    """A strip whose last part lies so far below the rest, in the picture."""
    along = np.arange(COLUMNS) - BEGIN
    rows = np.arange(ROWS)[:, None] - MIDDLE
    below = aside_px * np.clip((along - END) / THICK + 2, 0, 1)
    lies = (np.abs(rows - below) < THICK / 2) & (along < END)
    return 60 + contrast * lies + np.random.default_rng(3).normal(0, noise, lies.shape)


def found(*images):
    return tip_middle_px(straight(float(END)), [grey(each) for each in images], OPTICS, THICK)


@pytest.mark.parametrize("aside_px", [-5.0, 0.0, 5.0])
def test_the_middle_of_a_tip_is_found_aside_of_a_curve_that_is_led_on_straight(aside_px):
    # the picture's rows are counted downwards, the plane's y upwards
    assert found(bent_tip(aside_px)) == pytest.approx(-aside_px, abs=0.7)


def test_it_is_found_in_whichever_channel_the_strip_shows():
    hidden = bent_tip(5.0, contrast=0.0)
    assert found(hidden, bent_tip(5.0)) == pytest.approx(-5.0, abs=0.7)


def test_a_tip_that_the_ground_hides_is_not_measured():
    assert found(bent_tip(5.0, contrast=4.0, noise=6.0)) is None


def test_what_is_wider_than_a_tip_is_another_thing():
    image = bent_tip(0.0)
    image[MIDDLE - 30 : MIDDLE + 30, BEGIN + END - 12 :] = 140.0
    assert found(image) is None


def test_a_fit_is_drawn_to_a_tip_that_is_seen():
    shape = straight(float(END))
    places = StatedPlaces.of(OPTICS, THICK)
    assert places.tip_offset_px(shape) is None
    tip = np.array([float(END), 5.0])
    places = StatedPlaces(
        clamp_px=places.clamp_px,
        clamp_sigma_px=places.clamp_sigma_px,
        on_strip_px=places.on_strip_px,
        sigma_px=places.sigma_px,
        tip_seen_px=tip,
        tip_seen_sigma_px=0.5,
    )
    assert places.tip_offset_px(shape) == pytest.approx(5.0)
    assert places.tip_sigma_px == 0.5
    normal, pull = places.information(shape)
    moved = shape.moved(np.linalg.solve(normal + 1e-6 * np.eye(len(normal)), pull))
    assert moved.y[-1] == pytest.approx(5.0, abs=0.3)
