"""What comes into sight beyond a hidden stretch must go on from the sheet before it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from labrig.vision import neutral_curve
from tests.cases import few


@pytest.mark.thorough
@pytest.mark.slow
def test_a_drawn_line_that_leaves_the_rolls_is_not_taken_for_the_sheets_end(scenes, known):
    """The side of a rectangle: taken for the last 13 % of the sheet it was nine pixels off."""
    seed = 6_600_079
    scene = scenes.make_scene(replace(scenes.mixed(seed), clutter=2 + seed % 10))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.1


def turned_beyond_a_disc(scene, turn_rad):
    """The image with the sheet's last quarter turned about its beginning, which a disc hides."""
    at = 3 * len(scene.truth_px) // 4
    centre = tuple(float(each) for each in scene.truth_px[at])
    size = scene.image.shape[::-1]
    beyond, hidden = (np.zeros(scene.image.shape, np.uint8) for _ in range(2))
    last = np.round(scene.truth_px[at:]).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(beyond, [last], False, 1, 13)
    ground = np.full_like(scene.image, np.median(scene.image))
    ground = np.clip(ground + np.random.default_rng(5).normal(0, 6, ground.shape), 0, 255)
    turn = cv2.getRotationMatrix2D(centre, float(np.degrees(turn_rad)), 1.0)
    moved = cv2.warpAffine(scene.image, turn, size)
    there = cv2.warpAffine(beyond, turn, size)
    image = np.where(there == 1, moved, np.where(beyond == 1, ground, scene.image))
    cv2.circle(hidden, tuple(round(each) for each in centre), 18, 1, -1)
    return np.where(hidden == 1, 95, image).astype(np.uint8)


@pytest.mark.slow
@pytest.mark.parametrize(("turn_rad", "ok"), few([(0.0, True), (0.25, False), (-0.25, False)]))
def test_a_sharp_turn_where_nobody_sees_it_is_refused(plain, known, scenes, turn_rad, ok):
    curve = neutral_curve(turned_beyond_a_disc(plain, turn_rad), *known(plain))
    assert curve.ok is ok
    if ok:
        assert scenes.rmse_px(curve.points_px, plain.truth_px) < 0.1
    else:
        assert "beyond a hidden stretch" in curve.why


def two_lines(gap_px, turn_rad, contrast):
    """A line from the jaw at (60, 240), and another of its width that begins beyond a gap."""
    image = np.full((480, 640), 60.0)
    lines = np.zeros(image.shape, np.uint8)
    corner = np.array([360.0, 240.0])
    ahead = np.array([np.cos(turn_rad), np.sin(turn_rad)])
    far = corner + np.array([gap_px, 0.25 * turn_rad * gap_px])
    for one, other in (((60.0, 240.0), corner), (far, far + (445 - 300 - gap_px) * ahead)):
        ends = [tuple(round(16 * each) for each in place) for place in (one, other)]
        cv2.line(lines, *ends, 255, 2, cv2.LINE_AA, 4)
    image[200:280, :60] += 60
    image = cv2.GaussianBlur(image + contrast / 255.0 * lines, (0, 0), 0.9)
    image += np.random.default_rng(3).normal(0, 4, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


@pytest.mark.slow
@pytest.mark.parametrize("contrast", few([20, 100]))
@pytest.mark.parametrize(("turn_rad", "ok"), few([(0.0, True), (0.6, False)]))
def test_a_line_that_begins_beyond_plain_background_is_no_sheet_unless_it_continues(
    plain, known, contrast, turn_rad, ok
):
    """A hole as short as the windows that contrast is measured in is a hole all the same."""
    rig = {"clamp_px": [60.0, 240.0], "origin_px": [60.0, 240.0], "clamp_angle_rad": 0.0}
    optics, strip = known(plain, **rig)
    curve = neutral_curve(two_lines(11, turn_rad, contrast), optics, strip)
    assert curve.ok is ok, curve.why
    assert ok or "beyond a hidden stretch" in curve.why


@pytest.mark.thorough
@pytest.mark.slow
def test_a_line_and_an_arc_of_a_sheets_length_are_no_sheet(scenes, known):
    """Eleven pixels of plain background lie between them, and a turn that no sheet makes there."""
    recipe = replace(scenes.mixed(9_900_099), sheet=False, rolls=False, clutter=16)
    scene = scenes.make_scene(recipe)
    assert not neutral_curve(scene.image, *known(scene)).ok
