"""An elongation is taken as straight; where no straight one fits the image, it may bend."""

from __future__ import annotations

import numpy as np
import pytest

from labrig.vision import StripGeometry, neutral_curve
from labrig.vision.curve.shape import ELONGATION_PIECES, make_basis, make_shape
from tests.labrig.vision.drawn_strips import BENT_UP, STRIP, off_px

STATED = "no straight elongation fits the image"


def with_elongation(free_m: float) -> StripGeometry:
    return StripGeometry(
        free_length_m=free_m,
        elongation_m=STRIP.free_length_m - free_m,
        thickness_m=STRIP.thickness_m,
    )


@pytest.mark.parametrize("free_m", [0.006, 0.012])
def test_the_curve_follows_an_elongation_that_bends_and_says_so(free_m: float) -> None:
    curve = neutral_curve(BENT_UP.image, BENT_UP.optics, with_elongation(free_m))
    assert curve.ok, curve.why
    assert off_px(curve.points_px, BENT_UP) < 0.1
    (told,) = (text for text in curve.warnings if text.startswith(STATED))
    turned_mrad = 1e3 * (BENT_UP.curvature_per_m or 0.0) * (STRIP.free_length_m - free_m)
    # a force at its end leaves its end straight, as this arc is not
    assert float(told.split()[-2]) == pytest.approx(turned_mrad, rel=0.15)


def test_the_curve_of_the_next_image_is_found_near_that() -> None:
    strip = with_elongation(0.012)
    first = neutral_curve(BENT_UP.image, BENT_UP.optics, strip)
    again = neutral_curve(BENT_UP.image, BENT_UP.optics, strip, start=first)
    assert again.ok
    assert len(again.parameters) == len(first.parameters)
    assert np.abs(again.points_px - first.points_px).max() < 0.02


def test_a_straight_elongation_has_no_part_of_its_own() -> None:
    straight = with_elongation(0.03 - 1e-4)
    curve = neutral_curve(BENT_UP.image, BENT_UP.optics, straight)
    assert curve.ok
    assert not any(text.startswith(STATED) for text in curve.warnings)


def test_the_basis_is_the_integral_of_its_curvature() -> None:
    basis = make_basis(45.0, 445.0, 9, 0.1, straight_rest=False)
    middle = (basis.curvature[1:] + basis.curvature[:-1]) / 2 * basis.step_px
    summed = np.vstack([np.zeros(basis.angle.shape[1]), np.cumsum(middle, axis=0)])
    joint = basis.angle.shape[1] - ELONGATION_PIECES - 1
    others = np.arange(basis.angle.shape[1]) != joint
    # where the curvature jumps, at the joint, a sum is off by up to half a step
    assert np.abs(summed - basis.angle)[:, others].max() < 0.6 * basis.step_px
    assert np.allclose(np.interp(basis.s[:-1] + basis.step_px / 2, basis.s, basis.angle[:, -1]),
                       basis.angle_mid[:, -1], atol=1e-3)  # fmt: skip
    parameters = np.zeros(basis.size)
    parameters[2 + joint] = 0.1 / basis.free_px
    turned = make_shape(basis, np.zeros(2), 0.0, parameters)
    assert turned.phi[basis.s < 45.0] == pytest.approx(0.0)
    assert turned.phi[basis.s > 45.1] == pytest.approx(0.1)
