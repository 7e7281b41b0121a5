"""A tip that becomes thinner, or fades, is followed beyond where the strip's profile ends."""

import numpy as np
import pytest

from labrig.vision.curve.shape import make_basis, make_shape
from labrig.vision.extraction import outline_shape
from labrig.vision.extraction.faint_tip import tip_beyond
from labrig.vision.fit.stated_places import StatedPlaces
from labrig.vision.search.work import OutlineWork
from tests.labrig.vision.test_strip_end import BEGIN, COLUMNS, OPTICS, grey, picture

END, TIP = 140, 160  # px from the clamp: of the strip's whole width, and of its tip
THICK = 10.0


def along():
    return np.arange(COLUMNS) - BEGIN


def narrowing():
    """(columns,) the thickness of a strip with a pointed tip, 1 px at its end."""
    at = along()
    tip = 1 + (THICK - 1) * (TIP - at) / (TIP - END)
    return np.where(at < END, THICK, np.where(at < TIP, tip, 0.0))


def fading():
    return 80 * np.clip((TIP - along()) / (TIP - END), 0, 1)


def found(image, aside_px=0.0, end_px=END):
    """The tip beyond an end of a straight curve that lies so far beside the strip."""
    basis = make_basis(185.0, 185.0, 6, 1.0)
    shape = make_shape(basis, np.array([0.0, aside_px]), 0.0, np.zeros(basis.size))
    return tip_beyond(shape, float(end_px), [grey(image)], OPTICS, THICK)


@pytest.mark.parametrize("image", [picture(narrowing(), 80.0), picture(THICK, fading())])
def test_a_tip_is_followed_to_where_it_is_lost(image):
    tip = found(image)
    assert 0.6 * (TIP - END) < tip.end_px - END < TIP - END + 2


def test_the_way_leads_on_from_where_the_curve_lies_beside_the_tip():
    rows = np.arange(100)[:, None] - 50
    aside = np.clip(along() - END, 0, None) * 0.3
    lies = np.abs(rows - aside) < narrowing() / 2
    image = 60 + 80.0 * lies + np.random.default_rng(3).normal(0, 2, lies.shape)
    tip = found(image)
    assert tip.end_px > END + 10
    # the picture's rows are counted downwards, and the plane's y upwards
    assert -0.6 < tip.way.slope[-1] < -0.1


def test_beyond_a_sharp_end_there_is_no_tip():
    assert found(picture(THICK, 80.0 * (along() < END))) is None


def test_what_stands_out_more_than_the_strip_is_another_thing():
    leaf = (along() >= END) & (along() < END + 30)
    assert found(picture(THICK, np.where(leaf, 200.0, 80.0 * (along() < END)))) is None


def test_where_the_ground_changes_it_is_not_known_what_goes_on():
    image = picture(narrowing(), 80.0)
    image[:, BEGIN + END :] += 60
    assert found(image) is None


def test_a_curve_shorter_than_the_strip_is_wide_shows_no_tip_and_warns_of_nothing():
    assert found(picture(narrowing(), 80.0), end_px=0.8 * THICK) is None


def test_a_strip_that_ends_at_its_clamp_has_no_tip():
    basis = make_basis(185.0, 185.0, 6, 1.0)
    shape = make_shape(basis, np.zeros(2), 0.0, np.zeros(basis.size))
    fitter = outline_shape._Fitter(
        images=[grey(picture(THICK, 80.0))],
        optics=OPTICS,
        width_px=THICK,
        places=StatedPlaces.of(OPTICS, THICK),
        work=OutlineWork(),
    )
    assert fitter.to_faint_tip(shape, 0.3 * THICK) == (shape, 0.0)
