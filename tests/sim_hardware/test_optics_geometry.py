"""Where the renderer puts things."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from sim_hardware.optics import CameraNoise, Jaws, Lens, Light, OpticsSettings, Renderer, Rolls
from sim_hardware.optics.geometry import Geometry, smooth_polyline
from tests.cases import few

PLAIN = OpticsSettings(
    jaws=Jaws(visible=False),
    rolls=Rolls(visible=False),
    light=Light(vignetting=0, gradient=(0, 0), unevenness=0),
    noise=CameraNoise(electrons_per_level=1e9, read_levels=0),
    background_level=0,
    sheet_level=255,
)
LENS = Lens(
    camera_matrix=((4200, 0, 310), (0, 4190, 250), (0, 0, 1)),
    distortion=(-0.9, 0.4, 1e-3, -2e-3, 0.3),
)


def arc(curvature_per_m: float, length_m: float = 0.045, angle_rad: float = 0.0) -> np.ndarray:
    """A circular arc (n, 2) from the origin."""
    s = np.linspace(0, length_m, 181)
    theta = curvature_per_m * s
    points = np.column_stack((np.sin(theta), 1 - np.cos(theta))) / curvature_per_m
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return points @ np.array([[cos, sin], [-sin, cos]])


def exact_image(settings: OpticsSettings, shape: np.ndarray) -> np.ndarray:
    """The image before the sensor rounds it to grey levels, (rows, columns)."""
    renderer = Renderer(settings)
    taken = []
    expose = renderer._expose
    renderer._expose = lambda frame, *rest: (
        taken.append(frame.astype(float)) or expose(frame, *rest)
    )
    renderer.render([shape], None, 0)
    return taken[0]


def distance_of_centroids(
    image: np.ndarray, expected_px: np.ndarray, curvature_per_px: float
) -> np.ndarray:
    """Signed offset in px between the centroids of cross-sections and a dense curve's points.

    Each pixel is given to the nearest place of the curve; the mean signed distance, weighted by
    brightness and a window along the curve (24 px, fading out so that no pixel is cut), is the
    centroid's offset there. More pixels lie outside a bend than inside; the weight takes that back.
    """
    tangent = np.gradient(expected_px, axis=0)
    tangent /= np.hypot(*tangent.T)[:, None]
    v, u = np.nonzero(image > 1e-6)
    pixels = np.column_stack((u, v)).astype(float)
    nearest = np.argmin(((pixels[:, None] - expected_px[None]) ** 2).sum(2), axis=1)
    offset = pixels - expected_px[nearest]
    across = tangent[nearest, 0] * offset[:, 1] - tangent[nearest, 1] * offset[:, 0]
    weight = image[v, u] / (1 + curvature_per_px * across)
    steps = np.hypot(*np.diff(expected_px, axis=0).T)
    at = np.concatenate(([0], np.cumsum(steps)))[nearest]
    middles = np.arange(16, at.max() - 28, 8)
    windows = [np.cos(np.clip((at - middle) / 24, -0.5, 0.5) * np.pi) ** 2 for middle in middles]
    return np.array([np.average(across, weights=weight * window) for window in windows])


@pytest.mark.slow
@pytest.mark.parametrize("curvature_per_m", few([1e-6, 24.0, -60.0, 100.0], first=2))
@pytest.mark.parametrize("angle_rad", few([0.0, 0.31], first=2))
def test_band_lies_on_its_curve_to_half_a_hundredth_of_a_pixel(
    curvature_per_m: float, angle_rad: float
) -> None:
    settings = PLAIN.model_copy(update={"origin_px": (120.3, 240.6)})
    shape = arc(curvature_per_m, 0.03, angle_rad)
    expected = Geometry(settings).to_pixels(smooth_polyline(shape, 2e-5)[0])
    # v runs down, so a curve that turns left in the world turns left in (u, -v) too.
    curvature_px = curvature_per_m / (settings.px_per_mm * 1000)
    offsets = distance_of_centroids(exact_image(settings, shape), expected, curvature_px)
    assert len(offsets) >= 25
    assert np.abs(offsets).max() < 0.005
    assert abs(offsets.mean()) < 0.003


def test_band_has_the_sheets_cross_section() -> None:
    settings = PLAIN.model_copy(update={"blur_px": 0.0})
    image = exact_image(settings, arc(1e-6, angle_rad=0.2))
    thickness_px = settings.sheet_thickness_m * settings.px_per_mm * 1000
    columns = image[:, 150:350].sum(axis=0) / 255 * np.cos(0.2)
    assert columns.mean() == pytest.approx(thickness_px, abs=1e-3)


def test_band_is_as_long_as_the_sheet() -> None:
    image = exact_image(PLAIN, arc(30.0))
    area = PLAIN.sheet_thickness_m * 0.045 * (PLAIN.px_per_mm * 1000) ** 2
    assert image.sum() / 255 == pytest.approx(area, rel=2e-4)


def test_elongation_is_drawn_with_its_own_thickness_and_level() -> None:
    settings = PLAIN.model_copy(update={"blur_px": 0.0, "elongation_level": 100.0})
    shape = np.array([[0.0, 0.0], [0.02, 0.0], [0.04, 0.0]])
    frame = Renderer(settings).render([shape], None, 0, sheet_length_m=0.02)
    u = settings.origin_px[0] + np.array([0.01, 0.03]) * settings.px_per_mm * 1000
    sheet, elongation = (frame[:, round(place)].astype(float) for place in u)
    # Whole grey levels leave half a level in each of the few pixels of a column open.
    assert sheet.sum() / 255 == pytest.approx(0.21 * 8.9, abs=0.02)
    assert elongation.sum() / 100 == pytest.approx(0.5 * 8.9, abs=0.04)
    assert elongation.max() == 100


def test_world_maps_to_pixels_as_the_calibration_file_says() -> None:
    settings = OpticsSettings(px_per_mm=9.1, origin_px=(60.5, 400.25), roll_rad=0.012)
    x_mm, y_mm = 31.0, 12.5
    turn = np.array([[np.cos(0.012), -np.sin(0.012)], [np.sin(0.012), np.cos(0.012)]])
    expected = np.array([60.5, 400.25]) + 9.1 * turn @ np.array([x_mm, -y_mm])
    found = Geometry(settings).to_pixels([[x_mm / 1000, y_mm / 1000]])[0]
    assert found == pytest.approx(expected, abs=1e-9)


def test_lens_distorts_as_opencv_does() -> None:
    settings = OpticsSettings(lens=LENS)
    points = np.random.default_rng(3).uniform((0, 0), (640, 480), (50, 2))
    matrix = np.array(LENS.camera_matrix)
    rays = np.column_stack((points, np.ones(50))) @ np.linalg.inv(matrix).T
    expected, _ = cv2.projectPoints(
        rays, np.zeros(3), np.zeros(3), matrix, np.array(LENS.distortion)
    )
    found = Geometry(settings).distort(points)
    assert found == pytest.approx(expected.reshape(-1, 2), abs=1e-9)
    assert np.abs(found - points).max() > 1


@pytest.mark.slow
def test_distorted_band_lies_on_the_distorted_curve() -> None:
    settings = PLAIN.model_copy(update={"lens": LENS, "roll_rad": 0.02})
    shape = arc(20.0)
    expected = Geometry(settings).to_pixels(smooth_polyline(shape, 2e-5)[0])
    offsets = distance_of_centroids(exact_image(settings, shape), expected, 20 / 8900)
    assert np.abs(offsets).max() < 0.005


def test_perfect_calibration_tells_where_the_sheet_leaves_the_clamp() -> None:
    settings = OpticsSettings(lens=LENS, roll_rad=0.01)
    content = settings.calibration()
    assert content["clamp_px"] == pytest.approx(Geometry(settings).to_pixels([[0, 0]])[0])
    assert content["polarity"] == "bright"
    assert content["camera_matrix"][0] == [4200, 0, 310]


@pytest.mark.parametrize("samples", [2, 3, 4, 5, 60])
def test_curve_between_its_samples_is_the_spline_that_scipy_makes(samples: int) -> None:
    random = np.random.default_rng(samples)
    shape = np.cumsum(random.uniform(0.2e-3, 1e-3, (samples, 2)), axis=0)
    points, at = smooth_polyline(shape, 1e-4)
    known = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(shape, axis=0).T))))
    assert at[-1] == pytest.approx(known[-1])
    assert np.max(np.diff(at)) <= 1e-4
    np.testing.assert_allclose(points, CubicSpline(known, shape)(at), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    "shape", [np.zeros((5, 2)), np.zeros((1, 2)), np.full((4, 2), np.nan), np.zeros(7)]
)
def test_a_shape_that_is_none_is_refused(shape: np.ndarray) -> None:
    with pytest.raises(ValueError, match="shape"):
        smooth_polyline(shape, 1e-4)
