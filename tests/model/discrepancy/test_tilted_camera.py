"""A camera may be tilted in any direction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.worlds.cases import PAPER
from benchmarks.worlds.registry import world
from model.discrepancy import diagnose
from tests.fits_unchecked import fits_unchecked


@pytest.mark.slow
def test_a_tilt_between_the_directions_that_are_tried_is_a_perspective_alone():
    """It was a wrong scale, or a perspective beside an error of the arc."""

    def tilted(image, size):
        across = image.x_m * np.cos(np.radians(22.0)) + image.y_m * np.sin(np.radians(22.0))
        share = 1.0 / (1.0 - size * across / 50e-3)
        return image.x_m * share, image.y_m * share

    one = world("elements")
    camera = replace(one.acts["camera_perspective"], image=tilted)
    other = replace(one, acts={**one.acts, "camera_perspective": camera})
    with fits_unchecked():
        found = diagnose(other.measure(PAPER, {"camera_perspective": 0.02}, 5))
    assert [effect.name for effect in found.effects] == ["camera_perspective"]
    assert found.effects[0].probability > 0.9
