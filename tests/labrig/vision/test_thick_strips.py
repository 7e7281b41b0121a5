"""Strips that fill many pixels: frayed, textured, light above and dark below."""

import json

import numpy as np
import pytest

from labrig.vision import Optics, StripGeometry, Tracker, neutral_curve
from labrig.vision.image.downscaling import downscaled_optics, scaled_places

PX_PER_MM, FREE_MM = 9.0, 100.0


@pytest.fixture(scope="module")
def frayed():
    """An image (700, 1100) of a frayed strip 15 pixels thick, and its middle line in pixels."""
    rng = np.random.default_rng(4)
    s = np.linspace(0.0, FREE_MM * PX_PER_MM, 2001)
    phi = 0.75 * (1 - np.exp(-s / 400))
    u = 60 + np.concatenate([[0.0], np.cumsum(np.cos(phi[1:]) * np.diff(s))])
    v = 120 + np.concatenate([[0.0], np.cumsum(np.sin(phi[1:]) * np.diff(s))])
    rows, columns = np.mgrid[0:700, 0:1100]
    along = np.interp(columns, u, np.arange(len(u)))
    middle, turn = np.interp(along, np.arange(len(u)), v), np.interp(along, np.arange(len(u)), phi)
    beside = (rows - middle) * np.cos(turn)
    knots = np.arange(0, 1101, 12)
    upper, lower = (
        np.interp(columns[0], knots, 7.5 + rng.normal(0, 1.2, len(knots))) for _ in range(2)
    )
    inside = (beside > -upper) & (beside < lower) & (columns > u[0]) & (columns < u[-1])
    shade = np.where(beside < 0, 200.0, 140.0) + rng.normal(0, 15, beside.shape)
    grey = np.where(inside, shade, 12.0) + rng.normal(0, 2, beside.shape)
    return np.clip(grey, 0, 255).astype(np.uint8), np.stack([u, v], axis=1)


def parts(line, thickness_mm=15 / PX_PER_MM):
    optics = {"px_per_mm": PX_PER_MM, "clamp_px": line[0].tolist()}
    known = thickness_mm is not None
    thickness_m = thickness_mm / 1000 if thickness_mm is not None else 0.21e-3
    strip = StripGeometry(
        free_length_m=FREE_MM / 1000,
        elongation_m=0.0,
        thickness_m=thickness_m,
        thickness_known=known,
    )
    return Optics.from_json(json.dumps(optics)), strip


@pytest.mark.slow
@pytest.mark.parametrize(
    "thickness_mm",
    [None, 2.0, *(pytest.param(t, marks=pytest.mark.thorough) for t in (1.2, 15 / PX_PER_MM))],
)
def test_a_frayed_strip_is_found_however_thick_it_is_said_to_be(frayed, scenes, thickness_mm):
    image, line = frayed
    curve = neutral_curve(image, *parts(line, thickness_mm))
    assert curve.ok, curve.why
    assert curve.covered > 0.8
    # as it is bright above, the middle of its light is 0.7 pixels above its own
    assert scenes.rmse_px(curve.points_px, line) < 0.03 * 15
    assert np.diff(curve.s_m).max() <= 0.5e-3
    assert curve.s_m[-1] * 1000 == pytest.approx(FREE_MM)


def lit(line, lighter):
    """A strip without frays whose upper half is `lighter` times as bright as its lower one."""
    rows, columns = np.mgrid[0:700, 0:1100]
    at = np.clip(np.searchsorted(line[:, 0], columns), 1, len(line) - 1)
    turn = np.arctan2(*np.diff(line, axis=0).T[::-1])[at - 1]
    beside = (rows - np.interp(columns, *line.T)) * np.cos(turn)
    inside = (np.abs(beside) < 7.5) & (columns > line[0, 0]) & (columns < line[-1, 0])
    grey = np.where(inside, np.where(beside < 0, 200.0, 200.0 / lighter), 12.0)
    grey += np.random.default_rng(1).normal(0, 3, grey.shape)
    return np.clip(grey, 0, 255).astype(np.uint8)


@pytest.mark.slow
@pytest.mark.parametrize("lighter", [1.0, 1.4, 2.0])
def test_light_on_one_side_draws_no_curve_aside(frayed, lighter):
    """Edges are where the image changes most; the middle of the light is up to 1.3 pixels off."""
    _, line = frayed
    curve = neutral_curve(lit(line, lighter), *parts(line))
    assert curve.ok, curve.why
    u, v = curve.points_px[8:-8].T
    beside = v - np.interp(u, *line.T)
    assert abs(np.mean(beside)) < 0.15
    assert np.sqrt(np.mean(beside**2)) < 0.2


@pytest.mark.slow
def test_a_thick_strip_is_followed_too(frayed):
    image, line = frayed
    tracker = Tracker(*parts(line))
    first, second = tracker.curve(image), tracker.curve(image)
    assert first.ok
    assert second.ok
    assert np.abs(second.points_px - first.points_px).max() < 0.5
    assert second.blur_px == pytest.approx(first.blur_px, rel=0.1)


LENS = {
    "px_per_mm": 9.0,
    "roll_rad": 0.1,
    "origin_px": [100.2, 200.7],
    "clamp_px": [101.0, 203.0],
    "camera_matrix": [[900, 0, 400.3], [0, 905, 300.8], [0, 0, 1]],
    "distortion": [-0.12, 0.08, 0.0006, -0.0004],
}
ASKEW = LENS | {"homography": [[9.0, 0.3, 100], [-0.2, -8.8, 210], [1e-5, 2e-5, 1]]}


@pytest.mark.parametrize("calibration", [LENS, ASKEW])
@pytest.mark.parametrize("by", [2, 5])
def test_the_calibration_of_a_reduced_image_says_the_same(calibration, by):
    optics = Optics.from_json(json.dumps(calibration))
    small = downscaled_optics(optics, by)
    places_m = np.array([[0.0, 0.0], [0.03, 0.01], [0.05, -0.02]])
    whole = optics.world_to_pixel(places_m)
    assert scaled_places(small.world_to_pixel(places_m), by) == pytest.approx(whole, abs=1e-6)
    assert small.clamp_m() == pytest.approx(optics.clamp_m(), abs=1e-7)


def test_a_pixel_of_a_reduced_image_has_its_centre_in_the_middle_of_its_pixels():
    first, last = np.array([0.0, 0.0]), np.array([2.0, 2.0])
    assert scaled_places((first + last) / 2, 1 / 3) == pytest.approx(np.zeros(2))
