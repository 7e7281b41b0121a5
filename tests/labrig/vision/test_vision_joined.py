"""What comes into sight beyond a hidden stretch must go on from the sheet before it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from labrig.vision import neutral_curve


@pytest.mark.slow
def test_a_drawn_line_that_leaves_the_rolls_is_not_taken_for_the_sheets_end(scenes, known):
    """The side of a rectangle: taken for the last 13 % of the sheet it was nine pixels off."""
    seed = 6_600_079
    scene = scenes.make_scene(replace(scenes.mixed(seed), clutter=2 + seed % 10))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.1


def turned_beyond_a_disc(scene, turn_rad):
    """The picture with the sheet's last quarter turned about its beginning, which a disc hides."""
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
@pytest.mark.parametrize(("turn_rad", "ok"), [(0.0, True), (0.25, False), (-0.25, False)])
def test_a_sharp_turn_where_nobody_sees_it_is_refused(plain, known, scenes, turn_rad, ok):
    curve = neutral_curve(turned_beyond_a_disc(plain, turn_rad), *known(plain))
    assert curve.ok is ok
    if ok:
        assert scenes.rmse_px(curve.points_px, plain.truth_px) < 0.1
    else:
        assert "beyond a hidden stretch" in curve.why
