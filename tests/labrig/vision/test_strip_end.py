"""Where a strip ends: along its own course, whatever it fades into or what is at its tip."""

import dataclasses

import numpy as np
import pytest

from labrig.vision import Optics
from labrig.vision.curve.shape import make_basis, make_shape
from labrig.vision.fit.course import StripCourse, completed, course_along
from labrig.vision.fit.outline_blocks import measure_blocks
from labrig.vision.image.image import read_grey_image

ROWS, COLUMNS, MIDDLE = 100, 260, 50
BEGIN = 20
OPTICS = Optics(px_per_mm=2.0, clamp_px=(float(BEGIN), float(MIDDLE)))
END = 160  # of the strips, px from the clamp


def picture(thick_px, light, noise=2.0):
    """One channel of a strip along the rows; `light` (columns,) over the ground."""
    rows = np.abs(np.arange(ROWS) - MIDDLE)[:, None]
    share = np.clip(np.broadcast_to(thick_px, COLUMNS) / 2 - rows + 0.5, 0, 1)
    grey = 60 + share * np.asarray(light)
    return grey + np.random.default_rng(7).normal(0, noise, grey.shape)


def grey(image):
    return read_grey_image(np.clip(np.round(image), 0, 255).astype(np.uint8), OPTICS)


def straight(length_px, heading_rad=0.0):
    basis = make_basis(length_px, length_px, 6, 1.0)
    return make_shape(basis, np.zeros(2), heading_rad, np.zeros(basis.size))


def there(at=END):
    """(columns,) 1 where the strip is."""
    return (np.arange(COLUMNS) < BEGIN + at).astype(float)


@pytest.mark.parametrize("thick_px", [3, 8, 16])
def test_a_sharp_end_is_found_within_its_uncertainty(thick_px):
    image = grey(picture(thick_px, 100 * there()))
    end, sigma = course_along(straight(220.0), [image], OPTICS, thick_px).end
    assert abs(end - END) < 0.25 * thick_px + 1
    assert sigma < thick_px


def test_a_strip_that_fades_is_followed_until_it_is_lost_in_noise():
    light = 60 * np.clip((BEGIN + END - np.arange(COLUMNS)) / END, 0, 1)
    image = grey(picture(4, light))
    end, _ = course_along(straight(220.0), [image], OPTICS, 4).end
    assert 0.8 * END < end < END + 4  # there it has a fifth of its light, five times the noise
    assert not course_along(straight(220.0), [image], OPTICS, 4).goes_on


def test_a_leaf_at_the_tip_is_no_part_of_the_strip_and_is_said():
    along = np.arange(COLUMNS) - BEGIN
    leaf = (along >= END) & (along < END + 30)
    thick = np.where(leaf, 14, 5)
    stem = 80 * there()
    images = [grey(picture(thick, stem + light * leaf)) for light in (-40, 30)]
    course = course_along(straight(220.0), images, OPTICS, 5)
    assert abs(course.end[0] - END) < 5
    assert course.goes_on
    assert not course_along(straight(220.0), [grey(picture(5, stem))], OPTICS, 5).goes_on


def test_what_crosses_a_strip_does_not_end_it():
    image = picture(6, 100 * there())
    image[:, BEGIN + 70 : BEGIN + 82] = 20
    assert abs(course_along(straight(220.0), [grey(image)], OPTICS, 6).end[0] - END) < 4


def course_of(said):
    """A course of which only the log odds of its blocks matter."""
    said = np.array(said, dtype=float)
    return StripCourse(
        block_px=2.0,
        said=said,
        profile_said=said,
        edges_said=said,
        backward=np.empty(0),
        shift_px=np.zeros(len(said)),
        unlike=said < -9,
        leaves_image=False,
        width_px=10.0,
        hidden=np.zeros(len(said), dtype=bool),
    )


@pytest.mark.parametrize(("further", "end_blocks"), [(12, 75), (4, 50)])
def test_a_crossing_counts_once_and_what_follows_must_be_seen_for_longer(further, end_blocks):
    course = course_of([2.0] * 50 + [-2.0] * 13 + [2.0] * further)
    assert course.end[0] == pytest.approx(2.0 * end_blocks, abs=1.0)


def test_a_strip_that_leaves_the_image_is_said_to_do_so():
    course = course_along(straight(300.0), [grey(picture(5, np.full(COLUMNS, 90.0)))], OPTICS, 5)
    assert course.leaves_image
    assert course.end[0] > COLUMNS - BEGIN - 8


def test_the_clamp_is_no_part_of_the_strip():
    image = picture(8, 100 * there())
    image[:, : BEGIN + 9] = 150
    course = course_along(straight(160.0), [grey(image)], OPTICS, 8, backward=True)
    assert 6 < course.begin(20.0) < 12
    assert course_along(straight(160.0), [grey(picture(8, 100 * there()))], OPTICS, 8).begin(0) == 0


def test_a_faint_stretch_is_seen_by_its_profile_and_one_edge_alone_is_not():
    light = np.interp(np.arange(COLUMNS), [BEGIN, BEGIN + 140], [60.0, 9.0])
    shape, image = straight(150.0), grey(picture(4, light))
    blocks = measure_blocks(shape, [image], OPTICS, 4, np.ones(len(shape.x)))
    more = completed(course_along(shape, [image], OPTICS, 4), blocks, shape.basis.step_px)
    faint = shape.basis.s[blocks.node] > 110
    assert more.seen[faint].mean() > blocks.seen[faint].mean() + 0.3
    assert np.abs(more.middle_px[more.by_profile]).max() < 1.3
    assert not more.by_edges[more.by_profile].any()
    course = course_along(shape, [image], OPTICS, 4)
    one_edge = dataclasses.replace(course, edges_said=np.full(len(course.said), -1.0))
    assert completed(one_edge, blocks, shape.basis.step_px).seen.sum() == blocks.seen.sum()
