import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from labrig.errors import BadInputError, LabrigWarning
from labrig.vision import BatchOptions, StripGeometry, extract_curves, load_strip

KEYS = ["image", "frame", "time_s", "ok", "x_mm", "y_mm", "s_mm", "curvature_per_m", "sigma_mm",
        "curvature_sigma_per_m", "points_px", "seen", "covered", "residual_px",
        "warnings", "why", "refused_at_px"]  # fmt: skip


@pytest.fixture
def folder(tmp_path, plain, scenes):
    scenes.save(plain, tmp_path, "good")
    cv2.imwrite(str(tmp_path / "black.png"), np.zeros((480, 640), np.uint8))
    (tmp_path / "damaged.png").write_bytes(b"not a picture")
    (tmp_path / "optics.json").write_text(json.dumps(plain.optics))
    (tmp_path / "sheet.toml").write_text("free_length_mm = 50\n")
    return tmp_path


def test_a_folder_gives_a_file_for_each_image(folder, plain, scenes, tmp_path):
    out = tmp_path / "results" / "today"
    seen = []
    result = extract_curves([folder], out, progress=lambda name, curve: seen.append(name))
    assert seen == ["black", "damaged", "good"]
    assert set(result.failed) == {"black", "damaged"}
    good = json.loads((out / "good.json").read_text())
    assert list(good) == KEYS
    assert good["ok"] is True
    assert len(good["x_mm"]) == len(good["points_px"]) == len(good["curvature_sigma_per_m"])
    assert scenes.rmse_px(np.array(good["points_px"]), plain.truth_px) < 0.05
    bad = json.loads((out / "damaged.json").read_text())
    assert list(bad) == KEYS
    assert not bad["ok"]
    assert "not an image" in bad["why"]
    assert bad["x_mm"] == []
    rows = (out / "curves.csv").read_text().splitlines()
    assert rows[0].startswith("image,point,s_mm,x_mm,y_mm,curvature_per_m,sigma_mm")
    assert len(rows) == 1 + len(good["x_mm"]) + len(result.failed)
    overlay = cv2.imread(str(out / "good_curve.png"))
    assert overlay.shape[1] == 1280  # twice as large, and its figures below it
    assert overlay.shape[0] > 960


def test_a_batch_that_is_stopped_keeps_the_rows_of_what_was_measured(folder):
    def stop_at(name, curve):
        if name == "damaged":
            raise KeyboardInterrupt

    out = folder / "out"
    with pytest.raises(KeyboardInterrupt):
        extract_curves([folder], out, progress=stop_at)
    rows = (out / "summary.csv").read_text().splitlines()[1:]
    assert [row.split(",")[0] for row in rows] == ["black", "damaged"]
    assert len((out / "curves.csv").read_text().splitlines()) == 3


def test_images_in_folders_of_the_folder_are_left_out_and_that_is_told(folder, scenes, plain):
    for name in ("monday", "tuesday"):
        (folder / name).mkdir()
        scenes.save(plain, folder / name, "more")
    (folder / "empty").mkdir()
    with pytest.warns(LabrigWarning, match=r"\(monday and tuesday\) are left out"):
        result = extract_curves([folder], folder / "out", BatchOptions(overlays=False))
    assert "more" not in result.curves
    assert "good" in result.curves


def test_a_folder_of_the_folder_that_cannot_be_read_costs_nothing(folder, monkeypatch):
    (folder / "private").mkdir()
    listed = Path.iterdir

    def iterdir(path):
        if path.name == "private":
            raise PermissionError(13, "Permission denied", str(path))
        return listed(path)

    monkeypatch.setattr(Path, "iterdir", iterdir)
    assert "good" in extract_curves([folder], folder / "out", BatchOptions(overlays=False)).curves


def test_a_video_is_followed_frame_by_frame(tmp_path, plain):
    header = b"YUV4MPEG2 W640 H480 F25:1 Ip A1:1 Cmono\n"
    frames = b"".join(b"FRAME\n" + plain.image.tobytes() for _ in range(3))
    (tmp_path / "film.y4m").write_bytes(header + frames)
    (tmp_path / "film.optics.json").write_text(json.dumps(plain.optics))
    (tmp_path / "film.sheet.toml").write_text("free_length_mm = 50\nthickness_mm = 0.21\n")
    result = extract_curves([tmp_path / "film.y4m"], tmp_path / "out", BatchOptions(overlays=False))
    assert list(result.curves) == ["film_000000", "film_000001", "film_000002"]
    assert all(c.ok for c in result.curves.values())
    assert not list((tmp_path / "out").glob("*.png"))


def test_what_is_missing_is_said(tmp_path, plain, scenes):
    with pytest.raises(BadInputError, match="no such file"):
        extract_curves([tmp_path / "none.png"], tmp_path / "out")
    with pytest.raises(BadInputError, match="no image"):
        extract_curves([tmp_path], tmp_path / "out")
    scenes.save(plain, tmp_path, "a")
    (tmp_path / "a.optics.json").unlink()
    with pytest.raises(BadInputError, match=r"neither a\.optics\.json nor optics\.json"):
        extract_curves([tmp_path / "a.png"], tmp_path / "out")


def test_two_images_never_write_one_file(tmp_path, plain, scenes):
    for folder in (tmp_path / "monday", tmp_path / "tuesday"):
        folder.mkdir()
        scenes.save(plain, folder, "a")
    with pytest.raises(BadInputError, match=r"both be written to a\.json"):
        extract_curves([tmp_path / "monday", tmp_path / "tuesday"], tmp_path / "out")


def test_a_sheet_file_may_be_small_or_whole(tmp_path):
    path = tmp_path / "sheet.toml"
    path.write_text("free_length_mm = 50\nelongation_mm = 0\n")
    assert load_strip(path).length_m == pytest.approx(0.05)
    assert not load_strip(path).thickness_known
    path.write_text(
        "[arc]\nradius_mm = 40\n[long]\nfree_length_mm = 50\nwidth_mm = 11\nthickness_mm = 0.3\n"
        "[short]\nfree_length_mm = 4.5\nelongation_mm = 40\nwidth_mm = 11\nthickness_mm = 0.2\n"
    )
    assert load_strip(path, "short").elongation_m == pytest.approx(0.04)
    with pytest.raises(BadInputError, match="choose one of long, short"):
        load_strip(path)
    path.write_text("free_lenght_mm = 50\n")
    with pytest.raises(BadInputError, match="free_length_mm is missing"):
        load_strip(path)
    path.write_text("free_length_mm = 50\nthicknes_mm = 1\n")
    with pytest.raises(BadInputError, match="did you mean thickness_mm"):
        load_strip(path)


def test_in_python_a_thickness_that_is_not_stated_is_measured_as_well(tmp_path):
    (tmp_path / "sheet.toml").write_text("free_length_mm = 50\n")
    assert StripGeometry(free_length_m=0.05) == load_strip(tmp_path / "sheet.toml")
    assert not StripGeometry(free_length_m=0.05).thickness_known
    assert StripGeometry(free_length_m=0.05, thickness_m=0.21e-3).thickness_known
    with pytest.raises(BadInputError, match="thickness is nan mm"):
        StripGeometry(free_length_m=0.05, thickness_m=float("nan"))


def test_a_fault_beside_one_image_costs_that_image_only(folder, plain, scenes):
    for name in ("alone", "bent", "cut"):
        scenes.save(plain, folder, name)
    (folder / "alone.optics.json").write_text('{"px_per_mm": -1, "clamp_px": [80, 240]}')
    (folder / "bent.sheet.toml").write_text("free_length_mm = = 50\n")
    (folder / "cut.mp4").write_bytes(b"no film")
    (folder / "cut.png").unlink()
    result = extract_curves([folder], folder / "out", BatchOptions(overlays=False))
    assert set(result.failed) == {"alone", "bent", "black", "cut", "damaged"}
    assert "alone.optics.json" in result.failed["alone"]
    assert "px_per_mm" in result.failed["alone"]
    assert "bent.sheet.toml" in result.failed["bent"]
    assert "not a video" in result.failed["cut"]


def test_what_one_image_lacks_costs_that_image_only(tmp_path, plain, scenes):
    scenes.save(plain, tmp_path, "whole")
    scenes.save(plain, tmp_path, "lacking")
    (tmp_path / "lacking.sheet.toml").unlink()
    result = extract_curves([tmp_path], tmp_path / "out", BatchOptions(overlays=False))
    assert list(result.failed) == ["lacking"]
    assert "neither lacking.sheet.toml nor sheet.toml" in result.failed["lacking"]


def test_a_fault_in_what_serves_all_images_is_found_before_the_first(folder):
    (folder / "sheet.toml").write_text("free_length_mm = -5\n")
    with pytest.raises(BadInputError, match="free_length_mm"):
        extract_curves([folder], folder / "out")
    assert not (folder / "out").exists()


def saved_stack(path, images, plain):
    cv2.imwritemulti(str(path), images)
    path.with_suffix(".optics.json").write_text(json.dumps(plain.optics))
    path.with_suffix(".sheet.toml").write_text("free_length_mm = 50\nthickness_mm = 0.21\n")


def tinted(image):
    return np.dstack([image // 2, image, image])


@pytest.mark.slow
def test_that_a_file_of_several_images_is_in_colour_is_told_once(tmp_path, plain):
    grey = np.dstack([plain.image] * 3)
    dark = np.zeros_like(grey)
    dark[..., 0] = 9  # refused, which is no place for a note
    images = [dark, grey, tinted(plain.image), tinted(plain.image)]
    saved_stack(tmp_path / "film.tif", images, plain)
    result = extract_curves([tmp_path], tmp_path / "out", BatchOptions(overlays=False))
    assert [curve.ok for curve in result.curves.values()] == [False, True, True, True]
    assert [curve.warnings for curve in result.curves.values()][1:] == [
        (),
        ("images of this file are in colour; their grey values were used",),
        (),
    ]


@pytest.mark.slow
def test_of_the_colours_of_one_image_one_thing_is_told(tmp_path, plain, scenes):
    scenes.save(plain, tmp_path, "a")
    cv2.imwrite(str(tmp_path / "a.png"), tinted(plain.image))
    (tmp_path / "a.sheet.toml").write_text("free_length_mm = 50\n")
    result = extract_curves([tmp_path], tmp_path / "out", BatchOptions(overlays=False))
    told = [text for text in result.curves["a"].warnings if "in colour" in text]
    assert told == ["the image is in colour; its grey values and differences of colours were used"]
