import datetime as dt
import math
import re
from functools import lru_cache

import cv2
import numpy as np
import pytest

from labrig.errors import BadInputError
from labrig.vision import (
    CalibrationBoard,
    Optics,
    calibrate_camera,
    calibrate_ruler,
    write_board_pdf,
)
from tests.cases import few

CAMERA = np.array([[1500, 0, 322.0], [0, 1500, 236.0], [0, 0, 1]])
LENS = np.array([-0.15, 0.1, 0.0005, -0.0004, 0])


@lru_cache
def view(board, turn, place, seed=0):
    """The board through a known lens, drawn in parts of a pixel."""
    turned, _ = cv2.Rodrigues(np.array(turn, float))
    plane = np.column_stack([turned[:, 0], turned[:, 1], place])
    fine = 2
    v, u = np.mgrid[0 : 480 * fine, 0 : 640 * fine]
    raw = np.stack([(u.ravel() + 0.5) / fine - 0.5, (v.ravel() + 0.5) / fine - 0.5], axis=1)
    rays = np.asarray(cv2.undistortPoints(raw.reshape(-1, 1, 2), CAMERA, LENS)).reshape(-1, 2)
    on = np.column_stack([rays, np.ones(len(rays))]) @ np.linalg.inv(plane).T
    at = (on[:, :2] / on[:, 2:] * 20 - 0.5).astype(np.float32).reshape(*u.shape, 2)
    drawn = cv2.remap(board.image(20), at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderValue=255)
    image = cv2.resize(drawn, (640, 480), interpolation=cv2.INTER_AREA) * 0.7 + 40
    image += np.random.default_rng(seed).normal(0, 2, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8), plane


def plane_error_um(optics: Optics, plane):
    """RMS error of the places in the plane where the board has corners, whatever its axes."""
    mm = np.stack(np.meshgrid(np.linspace(5, 55, 15), np.linspace(5, 40, 12)), -1).reshape(-1, 2)
    on = np.column_stack([mm, np.ones(len(mm))]) @ plane.T
    rays = np.column_stack([on[:, :2] / on[:, 2:], np.ones(len(on))])
    raw, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), CAMERA, LENS)
    found = optics.pixel_to_world(np.asarray(raw).reshape(-1, 2)) * 1000
    a, b = (mm - mm.mean(0)) * (1, -1), found - found.mean(0)
    u, _, vt = np.linalg.svd(a.T @ b)
    return float(np.sqrt(((a @ u @ vt - b) ** 2).sum(axis=1).mean())) * 1000


@pytest.mark.slow
@pytest.mark.parametrize(
    "board", few([CalibrationBoard(), CalibrationBoard(marker_mm=0)]), ids=["charuco", "checker"]
)
def test_one_flat_view_measures_the_plane_to_a_few_um(board):
    image, plane = view(board, (0.02, -0.02, 0.01), (-30, -22.5, 170))
    result = calibrate_camera([image], board, clamp_px=(80.0, 240.0))
    assert plane_error_um(result.optics, plane) < 5
    assert result.residual_px < 0.25
    assert result.optics.image_size == (640, 480)
    assert 0 < result.optics.px_per_mm_sigma < 0.02
    assert Optics.from_json(result.optics.to_json()) == result.optics


@pytest.mark.slow
def test_the_world_starts_at_the_clamp_and_runs_along_the_sheet():
    board = CalibrationBoard()
    image, _ = view(board, (0, 0, 0.03), (-30, -22.5, 170))
    o = calibrate_camera([image], board, clamp_px=(80.0, 240.0), along_px=(200.0, 230.0)).optics
    assert o.clamp_m() == pytest.approx([0, 0], abs=1e-9)
    x, y = o.pixel_to_world([[200.0, 230.0], [80.0, 100.0]])
    assert x[1] == pytest.approx(0, abs=1e-9)
    assert x[0] > 0
    assert y[1] > 0  # up in the picture
    assert math.isclose(o.roll_rad, math.atan2(-10, 120), abs_tol=0.01)


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize(
    "board",
    [
        pytest.param(CalibrationBoard(), id="charuco"),
        pytest.param(CalibrationBoard(marker_mm=0), id="checker", marks=pytest.mark.thorough),
    ],
)
def test_tilted_views_fix_the_lens(board):
    flat, plane = view(board, (0.01, -0.02, 0.015), (-30, -22.5, 170))
    tilted = [view(board, (0.3 * math.cos(q), 0.3 * math.sin(q), 0), (-30, -22, 215), q)[0]
              for q in range(1, 5)]  # fmt: skip
    result = calibrate_camera([flat, *tilted], board, clamp_px=(80.0, 240.0))
    assert result.optics.views == 5
    assert plane_error_um(result.optics, plane) < 5


@pytest.mark.slow
def test_what_cannot_be_calibrated_is_said():
    board = CalibrationBoard()
    image, _ = view(board, (0.01, -0.02, 0.015), (-30, -22.5, 170))
    with pytest.raises(BadInputError, match="differ in size"):
        calibrate_camera([image, image[:400]], board, clamp_px=(80, 240))
    with pytest.raises(BadInputError, match="image 1: only 0 corners"):
        calibrate_camera([np.full((480, 640), 90, np.uint8)], board, clamp_px=(80, 240))
    with pytest.raises(BadInputError, match="the whole checkerboard"):
        calibrate_camera([image[:, :300]], CalibrationBoard(marker_mm=0), clamp_px=(80, 240))
    with pytest.raises(BadInputError, match=r"clamp_px \(900, 240\) is outside"):
        calibrate_camera([image], board, clamp_px=(900, 240))
    with pytest.raises(BadInputError, match=r"along_px is 5\.0 pixels from"):
        calibrate_camera([image], board, clamp_px=(80, 240), along_px=(85, 240))
    with pytest.raises(BadInputError, match="at least one"):
        calibrate_camera([], board, clamp_px=(80, 240))
    with pytest.raises(BadInputError, match="smaller than its square"):
        CalibrationBoard(marker_mm=6.0)


def test_a_ruler_gives_a_scale_and_says_what_it_does_not_give():
    day = dt.date(2026, 11, 21)
    result = calibrate_ruler((640, 480), (100, 100), (500, 100), 45.0, clamp_px=(80, 240), date=day)
    assert result.optics.px_per_mm == pytest.approx(400 / 45)
    assert result.optics.px_per_mm_sigma == pytest.approx(400 / 45 * math.sqrt(2) * 0.7 / 400)
    assert result.optics.date == "2026-11-21"
    assert "distortion" in result.warnings[0]
    with pytest.raises(BadInputError, match="outside of the image"):
        calibrate_ruler((640, 480), (100, 100), (500, 100), 45.0, clamp_px=(80, 480))
    with pytest.raises(BadInputError, match="20 pixels"):
        calibrate_ruler((640, 480), (100, 100), (105, 100), 1.0, clamp_px=(80, 240))
    with pytest.raises(BadInputError, match=r"ruler's point \(9460, 100\) is outside of the image"):
        calibrate_ruler((640, 480), (60, 100), (9460, 100), 40.0, clamp_px=(80, 240))
    for number in (math.nan, math.inf, -3.0):
        with pytest.raises(BadInputError, match=f"pixels and {number:g} mm apart"):
            calibrate_ruler((640, 480), (60, 100), (460, 100), number, clamp_px=(80, 240))
    with pytest.raises(BadInputError, match=r"4e\+04 pixels a mm; is its length in mm\?"):
        calibrate_ruler((640, 480), (100, 100), (500, 100), 0.01, clamp_px=(80, 240))


def test_a_ruler_in_metres_is_asked_about():
    short = calibrate_ruler((640, 480), (100, 100), (300, 100), 0.03, clamp_px=(80, 240))
    assert any("is its length in mm?" in note for note in short.warnings)
    usual = calibrate_ruler((640, 480), (100, 100), (300, 100), 30.0, clamp_px=(80, 240))
    assert not any("is its length in mm?" in note for note in usual.warnings)


def test_a_ruler_says_that_the_direction_is_found_where_none_is_stated():
    upright = calibrate_ruler((640, 480), (100, 100), (100, 400), 45.0, clamp_px=(80, 240))
    assert upright.optics.roll_rad == 0
    assert not upright.optics.clamp_angle_known
    assert "found in each image" in upright.warnings[1]
    assert "--along-px" in upright.warnings[1]


@pytest.mark.parametrize("along_px", [(80, 400), (200, 240), (10, 100), (180, 340)])
def test_beside_a_ruler_a_second_pixel_states_the_sheets_direction(along_px):
    clamp_px = (80, 240)
    found = calibrate_ruler(
        (640, 480), (100, 100), (500, 100), 50.0, clamp_px=clamp_px, along_px=along_px
    )
    x_m, y_m = found.optics.pixel_to_world([along_px])[0]
    assert x_m == pytest.approx(math.dist(along_px, clamp_px) / 8000)
    assert y_m == pytest.approx(0, abs=1e-12)
    assert len(found.warnings) == 1
    with pytest.raises(BadInputError, match="along_px is"):
        calibrate_ruler(
            (640, 480), (100, 100), (500, 100), 50.0, clamp_px=(80, 240), along_px=(81, 240)
        )


@pytest.mark.slow
def test_the_board_prints_at_its_true_size(tmp_path):
    path = tmp_path / "board.pdf"
    import matplotlib as mpl  # slow to import

    with mpl.rc_context({"pdf.compression": 0}):
        write_board_pdf(path, CalibrationBoard())
    data = path.read_bytes()
    mm = 72 / 25.4
    page = [float(x) for x in re.search(rb"/MediaBox \[ ([\d. ]+) \]", data)[1].split()]
    assert page == pytest.approx([0, 0, 90 * mm, 85 * mm], abs=0.01)
    # 12 x 9 squares of 5 mm: the matrix that the board's picture, one unit wide, is drawn with
    drawn = re.search(
        rb"0 0 1 ([\d.]+) ([\d.]+) cm ([\d.]+) 0 0\s-([\d.]+) 0 [\d.]+ cm /I1 Do", data
    )
    wanted = [15 * mm, 25 * mm, 60 * mm, 45 * mm]
    assert [float(x) for x in drawn.groups()] == pytest.approx(wanted, abs=0.02)
