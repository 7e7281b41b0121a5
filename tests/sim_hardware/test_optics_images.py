"""What the images look like, and that each can be made again."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.special import ndtr

from sim_hardware.optics import (
    CameraNoise,
    FarFace,
    Jaws,
    Light,
    OpticsSettings,
    Renderer,
    Spot,
    read_marker,
)

SHAPE = np.column_stack((np.linspace(0, 0.05, 60), 0.004 * np.linspace(0, 1, 60) ** 2))
MOVING = [SHAPE * [1, 1 + 0.1 * k] for k in range(5)]
CONTACT = (0.0395, 0.0026, 0.14)


def test_a_frame_can_be_rendered_again_on_its_own() -> None:
    one = Renderer(OpticsSettings(), seed=4)
    frames = [one.render(MOVING, CONTACT, number) for number in range(5)]
    again = Renderer(OpticsSettings(), seed=4).render(MOVING, CONTACT, 3)
    assert np.array_equal(frames[3], again)
    assert not np.array_equal(frames[3], frames[2])
    assert not np.array_equal(frames[3], Renderer(OpticsSettings(), seed=5).render(MOVING, None, 3))


def test_nothing_of_a_frame_is_left_in_the_next() -> None:
    renderer = Renderer(OpticsSettings(far_face=FarFace(level=90)))
    alone = renderer.render([SHAPE], None, 1)
    renderer.render(MOVING, CONTACT, 0)
    assert np.array_equal(renderer.render([SHAPE], None, 1), alone)


@pytest.mark.slow
def test_noise_is_white_and_as_strong_as_the_settings_say() -> None:
    settings = OpticsSettings(light=Light(vignetting=0, gradient=(0, 0)), jaws=Jaws(visible=False))
    renderer = Renderer(settings)
    stack = np.array([renderer.render([], None, k) for k in range(12)], dtype=float)
    expected = 40 / settings.noise.electrons_per_level + settings.noise.read_levels**2 + 1 / 12
    deviation = stack - 40
    assert deviation.mean() == pytest.approx(0, abs=0.02)
    assert deviation.var() == pytest.approx(expected, rel=0.005)
    assert (deviation**4).mean() / deviation.var() ** 2 == pytest.approx(3 - 0.15, abs=0.03)
    for a, b in [
        (deviation[:, :, 1:], deviation[:, :, :-1]),
        (deviation[:, 1:], deviation[:, :-1]),
        (deviation[1:], deviation[:-1]),
    ]:
        assert (a * b).mean() / expected == pytest.approx(0, abs=0.003)


def test_default_signal_to_noise_ratio_is_between_20_and_40() -> None:
    renderer = Renderer(OpticsSettings())
    frames = np.array([renderer.render([SHAPE], None, k) for k in range(20)], dtype=float)
    noise = frames[:, 50:150, 300:500].std(axis=0).mean()
    contrast = frames.mean(axis=0)[250:400, 150:450].max(axis=0) - frames[:, 50:150, 300:500].mean()
    assert 20 < contrast.mean() / noise < 40


def test_a_moving_sheet_is_blurred_over_the_exposure() -> None:
    quiet = OpticsSettings(noise=CameraNoise(electrons_per_level=1e9, read_levels=0))
    still, moving = (Renderer(quiet).render(shapes, None, 0) for shapes in ([SHAPE], MOVING))
    column = slice(250, 400), 480
    assert moving[column].max() < 0.75 * still[column].max()
    light = [frame[column].astype(float).sum() for frame in (still, moving)]
    assert light[1] == pytest.approx(light[0], rel=0.01)


def test_dark_sheet_before_a_bright_background() -> None:
    settings = OpticsSettings(background_level=200, sheet_level=40)
    frame = Renderer(settings).render([SHAPE], None, 0)
    assert settings.polarity == "dark"
    assert frame[330:342, 200].min() < 100 < frame[100, 200]


@pytest.mark.parametrize(("sheet_length_m", "held_mm"), [(0.05, 0.21), (0.0045, 0.5)])
def test_rolls_touch_the_sheet_or_its_elongation_on_both_sides(
    sheet_length_m: float, held_mm: float
) -> None:
    quiet = OpticsSettings(noise=CameraNoise(electrons_per_level=1e9, read_levels=0))
    straight = np.array([[0, 0], [0.05, 0.0]])
    renderer = Renderer(quiet)
    with_rolls, without = (
        renderer.render([straight], contact, 0, sheet_length_m=sheet_length_m).astype(float)
        for contact in ((0.04, 0.0, 0.0), None)
    )
    changed = np.abs(with_rolls - without) > 10
    rows, columns = np.nonzero(changed)
    u, v = quiet.origin_px[0] + 356, quiet.origin_px[1]
    assert columns.mean() == pytest.approx(u, abs=0.5)
    assert rows.mean() == pytest.approx(v, abs=0.5)
    assert rows.max() - v == pytest.approx((2.4 + held_mm / 2) * 8.9, abs=1.0)


def test_far_face_lies_towards_the_middle_of_the_image() -> None:
    quiet = OpticsSettings(noise=CameraNoise(electrons_per_level=1e9, read_levels=0))
    face = quiet.model_copy(update={"far_face": FarFace(level=90)})
    changed = Renderer(face).render([SHAPE], None, 0).astype(float)
    changed -= Renderer(quiet).render([SHAPE], None, 0)
    rows = np.nonzero(changed[:, 300] > 10)[0]
    edge = quiet.origin_px[1]
    shift = (edge - 239.5) * (1 - 1 / (1 + 11 / 470))
    assert edge - 20 < rows.min() < rows.max() < edge
    assert len(rows) == pytest.approx(shift, abs=2)


def test_nothing_of_the_far_face_shines_through_the_edge_before_it() -> None:
    """The face lay under the edge as well, and moved it by 0.08 pixels."""
    quiet = OpticsSettings(
        noise=CameraNoise(electrons_per_level=1e9, read_levels=0),
        light=Light(vignetting=0, gradient=(0, 0), unevenness=0),
    )
    face = quiet.model_copy(update={"far_face": FarFace(level=90)})
    added = Renderer(face).render([SHAPE * [1, 0]], None, 0)[:, 300].astype(float)
    added -= Renderer(quiet).render([SHAPE * [1, 0]], None, 0)[:, 300]
    half = quiet.sheet_thickness_m * quiet.px_per_mm * 500
    size = 1 / (1 + 11 / 470)
    shown = (quiet.origin_px[1] - 239.5) * (1 - size) - (1 - size) * half
    beyond = quiet.origin_px[1] - np.arange(len(added)) - half  # of the edge, towards the middle
    sigma = math.hypot(quiet.blur_px, 1 / math.sqrt(12))
    expected = 50 * (ndtr(beyond / sigma) - ndtr((beyond - shown) / sigma))
    assert np.abs(added - expected).max() < 2.0


def test_a_spot_brightens_its_place() -> None:
    settings = OpticsSettings(spots=(Spot(at_px=(500, 60), radius_px=4, level=150),))
    frame = Renderer(settings).render([], None, 0).astype(float)
    assert frame[58:63, 498:503].mean() > frame[100:200, 500:600].mean() + 100


@pytest.mark.parametrize("time_s", [None, 12.345678])
def test_marker_tells_the_frame_number_and_the_time(time_s: float | None) -> None:
    frame = Renderer(OpticsSettings(marker=True)).render([SHAPE], None, 70_001, time_s=time_s)
    assert read_marker(frame) == (70_001, time_s)


def test_an_image_without_marker_has_none() -> None:
    assert read_marker(Renderer(OpticsSettings()).render([SHAPE], None, 0)) is None
    assert read_marker(np.zeros((480, 640), dtype=np.uint8)) is None


@pytest.mark.parametrize(
    ("values", "where"),
    [
        ({"px_per_milimetre": 9}, "px_per_milimetre"),
        ({"noise": {"read": 3}}, "noise.read"),
        ({"blur_px": -1}, "blur_px"),
        ({"blur_px": float("nan")}, "blur_px"),
        ({"exposure_s": 0.2}, "exposure_s"),
        ({"sheet_level": 40}, "sheet_level"),
        ({"marker": True, "image_size": [320, 240]}, "image_size"),
        ({"lens": {"camera_matrix": [[1, 0, 0]], "distortion": [0, 0, 0, 0]}}, "camera_matrix"),
    ],
)
def test_a_wrong_setting_is_named(values: dict[str, object], where: str) -> None:
    with pytest.raises(ValidationError) as caught:
        OpticsSettings.model_validate(values)
    error = caught.value.errors()[0]
    assert where in ".".join(map(str, error["loc"])) + error["msg"]
