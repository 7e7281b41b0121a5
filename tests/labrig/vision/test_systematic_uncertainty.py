"""How well any number of images shows a curve: worse where they are blurred or show a face."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from labrig.vision import neutral_curve
from labrig.vision.uncertainty.parts import (
    SECTION_SIGMA_PX,
    SIDE_FACE_SIGMA_RATIO,
    systematic_sigma_px,
)
from tests.labrig.vision.drawn_strips import BENT_UP, STRIP


def test_a_sharp_image_shows_it_to_a_few_thousandths_of_a_pixel() -> None:
    curve = neutral_curve(BENT_UP.image, BENT_UP.optics, STRIP)
    assert systematic_sigma_px(curve) == pytest.approx(SECTION_SIGMA_PX, rel=0.3)


def test_a_blurred_image_shows_it_worse() -> None:
    """What the template misses of rolls and ends grows with their blur."""
    blurred = cv2.GaussianBlur(BENT_UP.image, (0, 0), 1.6)
    curve = neutral_curve(blurred, BENT_UP.optics, STRIP)
    assert curve.ok, curve.why
    assert systematic_sigma_px(curve) > 3.0 * SECTION_SIGMA_PX
    assert np.min(curve.sigma_m) * BENT_UP.optics.px_per_m > 3.0 * SECTION_SIGMA_PX


def test_a_side_face_counts_by_its_width_and_its_grey() -> None:
    curve = neutral_curve(BENT_UP.image, BENT_UP.optics, STRIP)
    faced = replace(curve, side_face_px=np.full(len(curve.s_m), 3.0), side_face_share=0.5)
    assert systematic_sigma_px(faced) == pytest.approx(
        np.hypot(systematic_sigma_px(curve), 1.5 * SIDE_FACE_SIGMA_RATIO)
    )
