"""The log odds along a strip's course, block by block."""

import numpy as np

from labrig.vision.fit.course_odds import ALL, log_odds

BLOCKS, ACROSS, HALF = 12, 41, 6


def odds(size):
    """Of a course whose edges show nothing, so that the profile alone decides."""
    middle = size.shape[2] // 2
    usual = np.median(size[:4, :, middle - HALF : middle + HALF + 1], axis=0)
    plain = np.ones(len(size))
    return log_odds(size, usual, plain, 1.0, plain, plain, few=2, far=8, memory=8.0, near=12)[ALL]


def course():
    size = np.random.default_rng(3).normal(0, 0.05, (BLOCKS, 1, ACROSS))
    size[:8, 0, 17:24] += np.sin(np.linspace(0, 2 * np.pi, 7))
    return size


def test_the_strip_is_likely_where_its_profile_shows_and_unlikely_beyond():
    said = odds(course())
    assert (said[:8] > 0.5).all()
    assert (said[8:] < 0).all()


def test_a_block_that_is_no_number_ends_nothing():
    size = course()
    size[3] = np.nan  # no image gives this; a compiled search for it would leave its array
    assert odds(size).shape == (BLOCKS,)
