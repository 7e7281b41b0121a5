import json

import cv2
import numpy as np
import pytest

from labrig.errors import BadInputError
from labrig.vision import Optics, load_optics

LENS = {
    "camera_matrix": [[700, 0, 318], [0, 700, 242], [0, 0, 1]],
    "distortion": [-0.15, 0.08, 0.0006, -0.0004, 0.01],
}


def optics(**more):
    return Optics.from_json(json.dumps({"px_per_mm": 8.9, "clamp_px": [80.4, 239.5]} | more))


def test_only_scale_and_clamp_are_required_and_the_origin_is_the_clamp():
    o = optics()
    assert o.world_to_pixel([[0, 0]])[0] == pytest.approx([80.4, 239.5])
    # 10 mm along the clamped sheet is to the right, 10 mm up is up
    assert o.world_to_pixel([[0.01, 0.01]])[0] == pytest.approx([169.4, 150.5])


def test_rotation_acts_on_pixel_coordinates():
    o = optics(roll_rad=0.1, origin_px=[100, 200])
    c, s = np.cos(0.1), np.sin(0.1)
    expected = np.array([100, 200]) + 89 * np.array([c, s])
    assert o.world_to_pixel([[0.01, 0]])[0] == pytest.approx(expected)


def test_the_lens_is_opencvs():
    o = optics(origin_px=[80, 240], **LENS)
    points = np.array([[0.0, 0.0], [0.05, 0.02], [0.03, -0.02]])
    ideal = np.array([80, 240]) + 8900 * points * (1, -1)
    matrix, lens = np.array(LENS["camera_matrix"], float), np.array(LENS["distortion"])
    rays = np.column_stack([(ideal - matrix[:2, 2]) / 700, np.ones(3)])
    shown, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, lens)
    assert o.world_to_pixel(points) == pytest.approx(np.asarray(shown).reshape(-1, 2), abs=1e-9)


@pytest.mark.parametrize(
    "more",
    [
        {},
        LENS,
        LENS | {"roll_rad": 0.2, "origin_px": [90.0, 250.0]},
        {"homography": [[8.9, 0.1, 80], [0.05, -8.9, 240], [1e-4, 2e-4, 1]]} | LENS,
    ],
)
def test_pixels_and_world_are_inverse(more):
    o = optics(**more)
    pixels = np.random.default_rng(0).uniform([0, 0], [640, 480], (200, 2))
    assert o.world_to_pixel(o.pixel_to_world(pixels)) == pytest.approx(pixels, abs=1e-6)


def test_what_is_written_reads_back_the_same():
    o = optics(**LENS, rolls_px=[[300, 200, 14]], date="2026-11-21")
    assert Optics.from_json(o.to_json()) == o


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "not valid JSON"),
        ("[]", "one JSON object"),
        ('{"px_per_mm": 8.9}', "clamp_px is missing"),
        ('{"px_per_mm": -1, "clamp_px": [1, 2]}', "px_per_mm = -1"),
        ('{"px_per_mm": NaN, "clamp_px": [1, 2]}', "px_per_mm"),
        ('{"px_per_mm": 9, "clamp_px": [1, 2], "polarty": "dark"}', "did you mean polarity"),
        ('{"px_per_mm": 9, "clamp_px": [1, 2], "distortion": [0.1, 0, 0, 0]}', "camera_matrix"),
    ],
)
def test_a_wrong_file_is_one_sentence_that_names_it(text, said, tmp_path):
    path = tmp_path / "optics.json"
    path.write_text(text)
    with pytest.raises(BadInputError, match=said) as caught:
        load_optics(path)
    assert "optics.json" in str(caught.value)


def test_a_missing_file_is_said(tmp_path):
    with pytest.raises(BadInputError, match="no such file"):
        load_optics(tmp_path / "nothing.json")
