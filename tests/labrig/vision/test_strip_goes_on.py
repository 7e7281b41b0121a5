"""A curve whose end is not surrounded by ground says that its strip may go on."""

import numpy as np
import pytest

from labrig.vision import Optics, StripGeometry, neutral_curve
from labrig.vision.checks.around_end import FARTHEST, shown_beyond
from labrig.vision.checks.kinds.strip_goes_on import CHECK
from labrig.vision.extraction.extract import unconfirmed_curve
from labrig.vision.image.image import read_grey_image
from labrig.vision.thresholds import STRIP_GOES_ON_MIN
from tests.cases import few

ROWS, COLUMNS = 140, 260
CLAMP, BEND, THICK = (20.0, 60.0), (180.0, 60.0), 8.0
OPTICS = Optics(px_per_mm=4.0, clamp_px=CLAMP)
TO_BEND = np.stack([np.linspace(CLAMP[0], BEND[0], 81), np.full(81, CLAMP[1])], axis=1)
SAID = CHECK.warning.split("{")[0]


def hooked(turn_deg, more_px=50.0, radius_px=10.0):
    """A line that is straight, then turns sharply and goes straight on."""
    turn = np.radians(turn_deg)
    arc = np.linspace(0, turn, 20)
    bend = np.array(BEND) + radius_px * np.stack([np.sin(arc), 1 - np.cos(arc)], axis=1)
    away = np.array([np.cos(turn), np.sin(turn)])
    return np.concatenate([TO_BEND, bend, bend[-1] + np.linspace(2, more_px, 25)[:, None] * away])


def picture(line, light=100.0, noise=2.0, along=None):
    """A strip along a line; `along` gives its light by the share of the line."""
    rows, columns = np.mgrid[0:ROWS, 0:COLUMNS]
    away = np.hypot(columns[..., None] - line[:, 0], rows[..., None] - line[:, 1])
    share = np.clip(THICK / 2 - away.min(axis=2) + 0.5, 0, 1)
    if along is not None:
        share = share * along(away.argmin(axis=2) / (len(line) - 1))
    grey = 60 + light * share + np.random.default_rng(3).normal(0, noise, share.shape)
    return np.clip(np.round(grey), 0, 255).astype(np.uint8)


def beyond(pixels, line=TO_BEND):
    return shown_beyond([read_grey_image(pixels, OPTICS)], line, THICK)


@pytest.mark.slow
@pytest.mark.parametrize("turn_deg", few([0, 60, 110, 150]))
def test_a_strip_that_goes_on_shows_beyond_the_end_of_its_curve(turn_deg):
    assert beyond(picture(hooked(turn_deg))) > 0.8


@pytest.mark.slow
@pytest.mark.parametrize("noise", [2.0, 25.0, 60.0])
def test_only_ground_shows_beyond_a_plain_end(noise):
    assert beyond(picture(TO_BEND, noise=noise)) < STRIP_GOES_ON_MIN


@pytest.mark.slow
def test_a_strip_that_fades_shows_less_of_itself_beyond_the_end():
    faint = picture(hooked(0, more_px=60), along=lambda share: np.where(share < 0.52, 1.0, 0.5))
    assert 0.35 < beyond(faint) < 0.65


def test_a_tip_that_becomes_thin_goes_on_at_half_the_width():
    line = hooked(0)
    rows, columns = np.mgrid[0:ROWS, 0:COLUMNS]
    thick = np.where(columns < BEND[0], THICK, 0.5 * THICK)
    share = np.clip(thick / 2 - np.abs(rows - CLAMP[1]) + 0.5, 0, 1) * (columns < line[-1, 0])
    grey = 60 + 100 * share + np.random.default_rng(3).normal(0, 2, share.shape)
    assert beyond(np.clip(np.round(grey), 0, 255).astype(np.uint8)) > 0.8


def test_a_curve_that_is_too_short_or_hidden_says_nothing():
    image = read_grey_image(picture(hooked(0)), OPTICS)
    assert shown_beyond([image], TO_BEND[:5], THICK) == 0.0
    hidden = image.without(np.ones((ROWS, COLUMNS), np.uint8))
    assert shown_beyond([hidden], TO_BEND, THICK) == 0.0


def test_a_line_that_crosses_beside_the_end_is_no_way_on():
    image = picture(TO_BEND)
    image[:, 215:218] = 160
    assert beyond(image) < STRIP_GOES_ON_MIN


def test_outside_of_the_image_nothing_shows():
    to_border = np.stack([np.linspace(20, COLUMNS - 1, 120), np.full(120, 60.0)], axis=1)
    assert beyond(picture(to_border), to_border) < STRIP_GOES_ON_MIN


def asked(pixels, *, length_known=False, tip_px=None, free_length_m=0.04, find=neutral_curve):
    optics = OPTICS.model_copy(update={"tip_px": tip_px, "clamp_angle_known": False})
    strip = StripGeometry(
        free_length_m=free_length_m, length_known=length_known, thickness_known=False
    )
    return find(pixels, optics, strip)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_curve_that_ends_at_a_hook_says_so():
    curve = asked(picture(hooked(150)), find=unconfirmed_curve)  # a second look leads it on
    assert curve.ok
    said = [text for text in curve.warnings if text.startswith(SAID)]
    u, v = curve.points_px[-1]
    assert said == [CHECK.warning.format(u=u, v=v)]
    assert curve.end_sigma_m * OPTICS.px_per_m > FARTHEST * THICK
    assert f"±{1e3 * curve.end_sigma_m:.1f} mm" in curve.warnings[0]


@pytest.mark.thorough
@pytest.mark.slow
def test_a_curve_to_a_plain_end_or_to_one_that_is_stated_says_nothing_of_it():
    plain, hook = picture(TO_BEND), picture(hooked(150))
    for curve in (
        asked(plain),
        asked(hook, tip_px=(BEND[0] + 5, BEND[1])),
        asked(plain, length_known=True),
    ):
        assert curve.ok
        assert not [text for text in curve.warnings if text.startswith(SAID)]


@pytest.mark.slow
def test_a_thick_strip_that_is_longer_than_stated_is_measured_up_to_there():
    """A part may be all that is wanted; where the thickness is stated, too, it is not."""
    rows, columns = np.mgrid[0:ROWS, 0:COLUMNS]
    share = np.clip(8.0 - np.abs(rows - CLAMP[1]) + 0.5, 0, 1) * (columns < 200)
    grey = 60 + 100 * share + np.random.default_rng(3).normal(0, 2, share.shape)
    pixels = np.clip(np.round(grey), 0, 255).astype(np.uint8)
    part_m = 0.03  # 120 of 180 pixels
    curve = asked(pixels, length_known=True, free_length_m=part_m)
    assert curve.ok, curve.why
    assert curve.s_m[-1] == pytest.approx(part_m)
    assert np.abs(curve.y_m).max() * OPTICS.px_per_m < 0.5
    (said,) = [text for text in curve.warnings if "after the stated" in text]
    assert said.endswith("after the stated 30.0 mm, up to which the curve was taken")
    stated = StripGeometry(free_length_m=part_m, thickness_m=16 / OPTICS.px_per_m)
    assert not neutral_curve(pixels, OPTICS, stated).ok
