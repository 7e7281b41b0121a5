"""The mean image's curve beside those of its frames."""

import numpy as np
import pytest

from labrig.vision import (
    NeutralCurve,
    average_of_frames,
    compare_with_frames,
    neutral_curve,
)
from model.measurements import Curve

PX_PER_MM = 10.0
S_M = np.linspace(0, 0.05, 101)


def line(offset_m, slope=0.3):
    """A straight sheet, moved along its normal."""
    c, s = np.cos(slope), np.sin(slope)
    return Curve(s_m=S_M, x_m=c * S_M - s * offset_m, y_m=s * S_M + c * offset_m)


def session(plain, known, amplitude_px):
    """Mean image and frames of a sheet that wanders up and down, compared."""
    rng = np.random.default_rng(0)
    frames = [
        np.clip(np.roll(plain.image.astype(float), round(amplitude_px * q), axis=0)
                + rng.normal(0, 2, plain.image.shape), 0, 255).astype(np.uint8)
        for q in np.linspace(-1, 1, 5)
    ]  # fmt: skip
    optics, strip = known(plain, clamp_sigma_px=5.0)
    curves = [neutral_curve(frame, optics, strip) for frame in frames]
    mean = neutral_curve((np.mean(frames, axis=0) * 256).astype(np.uint16), optics, strip)
    return compare_with_frames(mean, curves, optics.px_per_mm)


@pytest.mark.slow
def test_frames_of_a_sheet_at_rest_agree_with_their_mean(plain, known):
    found = session(plain, known, 0)
    assert found.agree
    assert found.average.frames == 5
    assert found.average.scatter_rms_m < 5e-6
    assert found.apart_m < 2e-6


@pytest.mark.slow
def test_frames_of_a_moving_sheet_do_not(plain, known):
    found = session(plain, known, 3)
    assert not found.agree
    assert "the sheet moved" in found.warnings[0]


def test_the_average_and_its_scatter_are_those_along_the_normal():
    average = average_of_frames([line(offset) for offset in (-2e-5, 0.0, 5e-5)])
    middle = line(1e-5)
    np.testing.assert_allclose(average.x_m, middle.x_m, atol=1e-12)
    np.testing.assert_allclose(average.y_m, middle.y_m, atol=1e-12)
    assert average.scatter_m == pytest.approx(np.std([-2e-5, 0, 5e-5], ddof=1))
    assert average.frames == 3


def test_a_mean_image_beside_the_frames_mean_is_reported():
    frames = [line(offset) for offset in (-1e-6, 0.0, 1e-6)]
    assert compare_with_frames(line(1e-6), frames, PX_PER_MM).agree
    found = compare_with_frames(line(4e-5), frames, PX_PER_MM)
    assert found.apart_m == pytest.approx(4e-5)
    assert "0.040 mm (RMS) from the mean" in found.warnings[0]


def test_movement_is_reported_without_a_curve_of_the_mean_image():
    frames = [line(offset) for offset in (-2e-4, 2e-4)]
    for missing in (None, NeutralCurve(ok=False, why="two sheets.")):
        found = compare_with_frames(missing, frames, PX_PER_MM)
        assert found.apart_m is None
        assert not found.agree
        assert "the sheet moved" in found.warnings[0]


def test_one_frame_is_nothing_to_compare_with():
    found = compare_with_frames(line(0.0), [line(0.0), NeutralCurve(ok=False)], PX_PER_MM)
    assert found.average is None
    assert not found.agree
    assert "fewer than two" in found.warnings[0]
