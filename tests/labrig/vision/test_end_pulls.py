"""What the own edges of a clamp and of a tip pull is taken back, by where these are stated."""

import numpy as np
import pytest

from labrig.vision.fit.stated_places import end_pull_px, likeliest_pull_px

WIDTH = 10.0
AWAY = np.arange(1.0, 60.0, 3.0)


def taken(middle_px, end_offset_px, end_sigma_px=1.5, sigmas_max=3.0):
    return likeliest_pull_px(
        AWAY,
        middle_px,
        AWAY < WIDTH,
        width_px=WIDTH,
        end_offset_px=end_offset_px,
        end_sigma_px=end_sigma_px,
        sigmas_max=sigmas_max,
    )


def test_a_pull_is_found_by_how_far_the_stated_end_lies_beside_the_middles():
    pulled = 3.0 * np.exp(-AWAY / WIDTH)
    left = pulled - taken(pulled, 0.0)
    near = AWAY < WIDTH
    assert np.abs(left[near]).max() < 0.6 * pulled[near].max()
    assert np.abs(taken(pulled, 0.0)[AWAY > 4 * WIDTH]).max() < 0.1


def test_an_end_that_is_known_badly_takes_less():
    pulled = end_pull_px(AWAY, WIDTH)
    well, badly = (taken(pulled, 0.0, end_sigma_px=sigma)[0] for sigma in (0.5, 5.0))
    assert well > 0.8 * pulled[0]
    assert badly < 0.4 * well


def test_edges_too_far_from_the_end_are_another_things():
    middle = np.full(len(AWAY), 12.0)
    assert not taken(middle, 0.0).any()
    assert taken(middle, 10.0).any()


def test_without_a_block_near_the_end_nothing_is_taken():
    none = likeliest_pull_px(
        AWAY,
        np.ones(len(AWAY)),
        np.zeros(len(AWAY), dtype=bool),
        width_px=WIDTH,
        end_offset_px=0.0,
        end_sigma_px=1.0,
        sigmas_max=3.0,
    )
    assert not none.any()


@pytest.mark.parametrize("width_px", [4.0, 10.0, 60.0])
def test_the_pull_is_a_share_of_the_width_and_at_most_3_pixels(width_px):
    assert end_pull_px(np.zeros(1), width_px)[0] == pytest.approx(min(0.3 * width_px, 3.0))
