"""The middle line of what stands out: from the clamp to the tip."""

from __future__ import annotations

import numpy as np
import pytest

from labrig.vision.extraction.salience.middle_line import distances, middle_line
from tests.labrig.vision.salient_strips import CLAMP, arc, strip_map


def line(salience, heading_rad=0.0, clamp=CLAMP):
    return middle_line(salience, clamp, heading_rad, pixel_px=1.0)


def test_it_follows_a_bent_strip_from_the_clamp_to_its_blunt_tip():
    found = line(strip_map(arc()))
    assert distances(found.path_px, arc())[5:-5].max() < 0.5
    assert np.hypot(*(found.path_px[-1] - arc()[-1])) < 1.5
    assert found.width_px == pytest.approx(12, abs=0.5)
    assert found.width_scatter < 0.03
    assert found.surely > 0.9


def test_it_follows_a_hook_to_its_end():
    hook = arc(length=200, turn=3.6)
    found = line(strip_map(hook))
    assert found.length_px == pytest.approx(200, abs=3)
    assert distances(found.path_px, hook).max() < 1.0


def test_what_holds_the_strip_behind_the_clamp_is_cut_off():
    held = strip_map(arc(), 12.0, (0, 60, 60, 120))
    assert line(held).length_px == pytest.approx(160, abs=3)
    turned = line(held, heading_rad=np.pi)  # the stated direction decides what is behind
    assert turned is None or turned.path_px[-1][0] < CLAMP[0]


def test_a_strip_that_tapers_evenly_has_no_scatter_of_its_width():
    path = arc(turn=0.0)
    wide = np.linspace(7.0, 3.0, len(path))
    wedge = np.vstack([path + np.c_[0 * wide, wide], (path - np.c_[0 * wide, wide])[::-1]])
    import cv2

    salience = np.zeros((240, 320), dtype=np.float32)
    cv2.fillPoly(salience, [np.round(wedge * 16).astype(np.int32)], 1.0, shift=4)
    assert line(cv2.GaussianBlur(salience, (0, 0), 1.0)).width_scatter < 0.05


def test_it_is_found_in_a_reduced_map_at_the_same_place():
    import cv2

    large = cv2.resize(strip_map(arc()), None, fx=3, fy=3, interpolation=cv2.INTER_LINEAR)
    found = line(large, clamp=3 * CLAMP + 1)
    assert distances(found.path_px, 3 * arc() + 1)[15:-15].max() < 1.5
    assert found.width_px == pytest.approx(36, abs=1.5)


def test_nothing_is_found_where_nothing_stands_out_near_the_clamp():
    assert line(np.zeros((240, 320), dtype=np.float32)) is None
    assert line(strip_map(arc()), clamp=np.array([60.0, 20.0])) is None
    assert line(strip_map(arc(length=1.5))) is None
