"""Straight things through the picture: found at the border, left out where they hide the sheet."""

import numpy as np
import pytest

from labrig.vision import neutral_curve
from labrig.vision.picture import read_picture
from labrig.vision.trace import ridge_maps
from labrig.vision.wires import find_wires


def drawn(paths, noise=6.0, seed=0):
    """A picture (300, 400) with bright lines two pixels wide along some paths [(u, v), ...]."""
    v, u = np.mgrid[0:300, 0:400].astype(float)
    grey = np.full(u.shape, 60.0)
    for (u0, v0), (u1, v1) in paths:
        length = np.hypot(u1 - u0, v1 - v0)
        along = ((u - u0) * (u1 - u0) + (v - v0) * (v1 - v0)) / length
        across = ((v - v0) * (u1 - u0) - (u - u0) * (v1 - v0)) / length
        inside = np.clip(along + 0.5, 0, 1) * np.clip(length - along + 0.5, 0, 1)
        grey += 80 * inside * np.exp(-0.5 * (across / 1.1) ** 2)
    grey += np.random.default_rng(seed).normal(0, noise, grey.shape)
    return np.clip(grey, 0, 255).astype(np.uint8)


def wires_in(image, known, plain, sign=1.0):
    optics, _ = known(plain, image_size=[400, 300])
    picture = read_picture(image, optics)
    return find_wires(picture, ridge_maps(picture, 1.9, wide=False), sign)


@pytest.mark.parametrize("noise", [1.0, 16.0])
def test_a_wire_through_the_picture_is_found_once_and_to_a_pixel(known, plain, noise):
    line = ((-20.0, 40.0), (430.0, 210.0))
    (wire,) = wires_in(drawn([line], noise), known, plain)
    du, dv = np.subtract(*line[::-1]) / np.hypot(*np.subtract(*line))
    across = (wire.path[:, 1] - line[0][1]) * du - (wire.path[:, 0] - line[0][0]) * dv
    assert np.abs(across).max() < 1
    assert np.ptp(wire.path[:, 0]) > 380
    assert 2.5 < wire.half_px < 4.5


def test_what_ends_before_the_border_is_no_wire(known, plain):
    image = drawn([((20.0, 150.0), (380.0, 120.0))])
    assert wires_in(image, known, plain) == []


def test_neither_is_an_edge_nor_a_line_of_the_other_brightness(known, plain):
    image = drawn([])
    image[:130] += 60
    assert wires_in(image, known, plain) == []
    assert wires_in(drawn([((-20.0, 40.0), (430.0, 210.0))]), known, plain, sign=-1.0) == []


def test_a_wire_that_ends_in_the_picture_is_followed_to_its_end(known, plain):
    (wire,) = wires_in(drawn([((410.0, 250.0), (150.0, 90.0))]), known, plain)
    assert wire.path[-1] == pytest.approx([150.0, 90.0], abs=12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "most_px"),
    [(950_396, 0.08), (990_058, 0.15), (950_299, 0.3), (700_219, 0.15), (700_374, 0.1)],
)
def test_a_sheet_is_measured_beside_a_wire_that_crosses_it_at_a_small_angle(
    scenes, known, seed, most_px
):
    scene = scenes.make_scene(scenes.mixed(seed))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < most_px
    # where the wire hides it the band is wide, and holds the truth
    assert curve.sigma_m.max() > 1.3 * np.median(curve.sigma_m)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [950_264, 950_314])
def test_a_sheet_that_a_wire_hides_too_far_is_refused(scenes, known, seed):
    scene = scenes.make_scene(scenes.mixed(seed))
    curve = neutral_curve(scene.image, *known(scene))
    assert not curve.ok
    assert "it is known to ±" in curve.why


@pytest.mark.parametrize("seed", [950_110, 950_193])
def test_a_straight_sheet_that_ends_near_the_border_is_no_wire(scenes, known, seed):
    scene = scenes.make_scene(scenes.mixed(seed))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.05
    assert curve.covered > 0.85
