"""A direction that is stated by a place far along a bent strip turns x and y, and is told."""

import math

import numpy as np
import pytest

from labrig.vision import Optics, StripGeometry, neutral_curve
from labrig.vision.extraction.outline_report import TURNED

CLAMP, RADIUS_PX, TURN = (30.0, 40.0), 150.0, 1.0
SAID = TURNED.split("{")[0]


def bent_strip():
    angle = np.linspace(0, TURN, 200)
    line = np.array(CLAMP) + RADIUS_PX * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
    rows, columns = np.mgrid[0:140, 0:220]
    away = np.hypot(columns[..., None] - line[:, 0], rows[..., None] - line[:, 1]).min(axis=2)
    grey = 200 - 140 * np.clip(4.5 - away, 0, 1)
    grey += np.random.default_rng(5).normal(0, 2, grey.shape)
    return np.clip(np.round(grey), 0, 255).astype(np.uint8)


@pytest.mark.usefixtures("one_look")
@pytest.mark.parametrize(("turned_deg", "warned"), [(0.0, False), (14.0, True)])
def test_a_direction_beside_the_beginning_of_the_strip_is_told(turned_deg, warned):
    optics = Optics(
        px_per_mm=4.0, clamp_px=CLAMP, roll_rad=math.radians(turned_deg), clamp_angle_known=True,
        clamp_angle_sigma_rad=0.1,
    )  # fmt: skip
    strip = StripGeometry(free_length_m=0.04, length_known=False, thickness_known=False)
    curve = neutral_curve(bent_strip(), optics, strip)
    assert curve.ok
    told = [text for text in curve.warnings if text.startswith(SAID)]
    assert bool(told) == warned
    if warned:
        degrees = int(told[0].split("clamp ")[1].split()[0])
        assert 8 <= degrees <= 15
