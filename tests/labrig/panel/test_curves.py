"""The curve in a picture, and the one that a model predicts."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from drivers.interfaces import Frame
from labrig.config import parse_sheet
from labrig.config.templates import template_text
from labrig.model_file import save_model
from labrig.panel.live.curve_process import Finder
from labrig.panel.live.frames import image_of, raw_picture
from labrig.panel.live.optics_message import setup_message
from labrig.panel.live.prediction import rms_distance
from labrig.vision import Optics
from model import Along, ConfiguredSheet, Parameter, SheetModel, predict
from protocols import Place, make_schedule
from protocols.kinds.pulse_train import PulseTrain

pytestmark = pytest.mark.slow
OPTICS = Optics.from_json(template_text("optics.json"))
SHEETS = parse_sheet(template_text("sheet.toml"), "sheet.toml")


def a_model(eibm_Nm_per_V: float = 4e-6) -> SheetModel:
    """Of the long sheet."""
    sheet = SHEETS["long"]
    assert sheet.initial_curvature is not None
    s_m, per_m = sheet.initial_curvature
    rest = Along(s_m, per_m, np.zeros(len(s_m)), "1/m")
    eibm = {
        v: Along.constant(Parameter(value=v * eibm_Nm_per_V, sigma=1e-7, unit="N m"))
        for v in (2.0, -2.0)
    }
    return SheetModel(
        sheets={
            "long": ConfiguredSheet(
                sheet, Parameter(value=5e-7, sigma=0.0, unit="N m^2"), rest, eibm
            )
        }
    )


def drawn(x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
    """A bright strip along a curve, as the camera would see it."""
    import cv2

    columns, rows = OPTICS.image_size or (640, 480)
    picture = np.full((rows, columns), 40, dtype=np.uint8)
    points = OPTICS.world_to_pixel(np.column_stack([x_m, y_m]))
    shift = 6
    fixed = np.round(points * 2**shift).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(picture, [fixed], False, 200, 1, cv2.LINE_AA, shift)
    noise = np.random.default_rng(1).normal(0, 2, picture.shape)
    return np.clip(cv2.GaussianBlur(picture, (0, 0), 0.8) + noise, 0, 255).astype(np.uint8)


def test_what_is_seen_and_what_was_expected_lie_on_each_other(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    save_model(a_model(), path)
    run = make_schedule(PulseTrain(), [Place("long", (0.010,))]).runs[0]
    wanted = predict(a_model(), "long", 0.010, 2.0)
    assert wanted.reachable
    image = drawn(wanted.x_m, wanted.y_m)
    header, raw = raw_picture(
        Frame(number=7, time_s=1.0, device_time_s=None, image=image),
        1.0,
        run,
        2.0,
        force_mN=1e3 * wanted.F_N - 0.25,
    )
    finder = Finder()
    finder.setup(json.loads(json.dumps(setup_message(OPTICS, SHEETS))))
    finder.choose_model(str(path))
    told = finder.curve(header, image_of(header, raw))
    assert (told["frame"], told["run"], told["ok"]) == (7, 0, True), told["why"]
    expected = np.array(told["model"]["points_px"])
    np.testing.assert_allclose(
        expected[[0, -1]],
        OPTICS.world_to_pixel(np.column_stack([wanted.x_m, wanted.y_m]))[[0, -1]],
        atol=4.0,
    )
    seen = np.array(told["points_px"])
    apart = np.hypot(*(seen[:, None] - expected[None]).transpose(2, 0, 1)).min(axis=1)
    assert np.median(apart) < 1.5  # the points of either are a pixel or two from one another
    assert told["model"]["force_mN"] == pytest.approx(1e3 * wanted.F_N)
    assert told["model"]["force_error_mN"] == pytest.approx(0.25, abs=1e-3)
    assert 0 < told["model"]["distance_mm"] < 0.05  # a fraction of a pixel
    json.dumps(told)


def test_the_error_of_a_prediction_is_the_distance_of_the_two_curves() -> None:
    """A model with another EIBM; the distance is computed here from points alone."""
    here, there = (predict(model, "long", 0.010, 2.0) for model in (a_model(), a_model(3e-6)))
    seen = np.column_stack([here.x_m, here.y_m])
    line = np.column_stack([there.x_m, there.y_m])
    fine = np.column_stack(
        [np.interp(np.linspace(0, 1, 20000), np.linspace(0, 1, len(line)), c) for c in line.T]
    )
    nearest = np.hypot(*(seen[:, None] - fine[None]).transpose(2, 0, 1)).min(axis=1)
    found = rms_distance(seen, line)
    assert found == pytest.approx(np.sqrt(np.mean(nearest**2)), rel=1e-3)
    assert found > 1e-4


def test_the_distance_of_points_from_a_line_is_that_of_geometry() -> None:
    line = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])
    points = np.array([[5.0, 3.0], [13.0, 5.0], [-3.0, 4.0], [10.0, 0.0]])
    assert rms_distance(points, line) == pytest.approx(np.sqrt((9 + 9 + 25 + 0) / 4))


def test_without_a_curve_or_a_reading_a_prediction_has_no_error(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    save_model(a_model(), path)
    run = make_schedule(PulseTrain(), [Place("long", (0.010,))]).runs[0]
    image = np.full((480, 640), 40, dtype=np.uint8)
    header, _ = raw_picture(
        Frame(number=1, time_s=0.0, device_time_s=None, image=image), 0.0, run, 2.0
    )
    finder = Finder()
    finder.setup(json.loads(json.dumps(setup_message(OPTICS, SHEETS))))
    finder.choose_model(str(path))
    told = finder.curve(header, image)["model"]
    assert (told["distance_mm"], told["force_error_mN"]) == (None, None)
    assert len(told["points_px"]) > 50


def test_without_a_model_or_with_a_broken_one_the_curve_is_told_all_the_same(
    tmp_path: Path,
) -> None:
    image = np.full((480, 640), 40, dtype=np.uint8)
    run = make_schedule(PulseTrain(), [Place("long", (0.010,))]).runs[0]
    header, _ = raw_picture(
        Frame(number=1, time_s=0.0, device_time_s=None, image=image), 0.0, run, 0.0
    )
    finder = Finder()
    assert "not known" in finder.curve(header, image)["why"]
    finder.setup(setup_message(OPTICS, SHEETS))
    told = finder.curve(header, image)
    assert (told["ok"], told["model"], told["points_px"]) == (False, None, [])
    (tmp_path / "model.toml").write_text("labrig_model = 99\n")
    finder.choose_model(str(tmp_path / "model.toml"))
    assert "model" in finder.curve(header, image)["model"]["why"]
