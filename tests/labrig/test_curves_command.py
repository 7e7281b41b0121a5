"""`labrig curves` and `labrig calibrate`: pictures and weights from the command line."""

from __future__ import annotations

import errno
import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.config import load_load_cell
from labrig.config.templates import template_text, write_templates
from labrig.vision import CalibrationBoard, load_optics
from sim_hardware.clock import VirtualClock
from sim_hardware.world import World, load_world

pytestmark = pytest.mark.slow
SHEET = "free_length_mm = 50.0\nelongation_mm = 0.0\nthickness_mm = 0.21\n"


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two pictures of the simulated long sheet, a blank one, and what is known of them."""
    folder = tmp_path_factory.mktemp("pictures")
    clock = VirtualClock()
    world = World(load_world(None), clock)
    world.mount("long")
    for number, position_m in enumerate((0.01, 0.025)):
        world.place(position_m)
        clock.sleep_until(clock.now() + 0.1)
        cv2.imwrite(str(folder / f"sheet{number}.png"), world.image(clock.now(), number))
    cv2.imwrite(str(folder / "blank.png"), np.full((480, 640), 40, np.uint8))
    (folder / "optics.json").write_text(template_text("optics.json"))
    (folder / "sheet.toml").write_text(SHEET)
    return folder


def arguments(folder: Path) -> list[str]:
    return ["--optics", str(folder / "optics.json"), "--sheet", str(folder / "sheet.toml")]


def test_a_file_that_is_stated_and_not_used_is_told(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("sheet0.png", "sheet1.png", "optics.json", "sheet.toml"):
        shutil.copy(pictures / name, tmp_path)
    shutil.copy(pictures / "optics.json", tmp_path / "sheet0.optics.json")
    stated = ["--optics", str(tmp_path / "optics.json")]
    assert run(["curves", str(tmp_path / "sheet0.png"), *stated]) == 0
    said = "optics.json is not used: each image has its own file beside it, such as sheet0.optics"
    assert said in capsys.readouterr().err
    both = [str(tmp_path / f"sheet{number}.png") for number in range(2)]
    assert run(["curves", *both, *stated]) == 0
    assert "not used" not in capsys.readouterr().err
    for option in ("--optics", "--sheet"):
        assert run(["curves", str(tmp_path / "sheet0.png"), option, "nix"]) == 2
        assert capsys.readouterr().err == "labrig: nix: there is no such file.\n"


def test_a_picture_gives_one_json_object(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = ["-o", str(tmp_path / "c.csv"), "--overlay", str(tmp_path / "o.png"), "--json"]
    assert run(["curves", str(pictures / "sheet0.png"), *arguments(pictures), *made]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["ok"] is True
    assert found["why"] == ""
    lengths = {len(found[key]) for key in ("x_mm", "y_mm", "s_mm", "sigma_mm", "points_px")}
    assert len(lengths) == 1
    assert max(np.diff(found["s_mm"])) <= 0.5
    assert found["s_mm"][-1] == pytest.approx(50.0)
    assert found["covered"] > 0.8
    rows = (tmp_path / "c.csv").read_text().splitlines()
    assert len(rows) == 1 + lengths.pop()
    assert cv2.imread(str(tmp_path / "o.png")) is not None


@pytest.mark.parametrize("option", ["-o", "--summary"])
def test_a_table_that_is_there_is_replaced_only_with_force(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    table = tmp_path / "mine.csv"
    table.write_text("precious")
    asked = ["curves", str(pictures / "sheet0.png"), *arguments(pictures), option, str(table)]
    assert run(asked) == 2
    told = capsys.readouterr()
    assert told.err == f"labrig: {table}: is already there; give --force to overwrite it.\n"
    assert told.out == ""  # nothing was measured
    assert table.read_text() == "precious"
    assert run([*asked, "--force"]) == 0
    assert table.read_text().startswith("image,")


def test_a_comparison_replaces_no_table_either(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "mine.csv"
    table.write_text("precious")
    asked = ["curves", str(pictures / "sheet0.png"), *arguments(pictures)]
    assert run([*asked, "--method", "column_means", "-o", str(table)]) == 2
    assert "is already there; give --force" in capsys.readouterr().err


def test_a_batch_replaces_tables_of_its_own_alone(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(pictures / "blank.png", tmp_path)
    out = tmp_path / "out"
    out.mkdir()
    (out / "curves.csv").write_text("configuration,position_mm,voltage_V,reading,point\n")
    asked = ["curves", "--batch", str(tmp_path), "-o", str(out), *arguments(pictures)]
    assert run(asked) == 2
    assert "curves.csv: this is no table of an earlier batch" in capsys.readouterr().err
    assert list(out.iterdir()) == [out / "curves.csv"]
    (out / "curves.csv").unlink()
    assert run(asked) == run(asked) == 0
    assert run([*asked, "--force"]) == 2
    assert "--batch replaces tables of its own alone" in capsys.readouterr().err


def test_what_cannot_be_written_is_told_before_an_image_is_measured(
    pictures: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(self: Path, **_: object) -> None:
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(Path, "touch", refused)
    for option, name in (("-o", "c.csv"), ("--summary", "c.csv"), ("--overlay", "o.png")):
        asked = ["curves", str(pictures / "sheet0.png"), *arguments(pictures)]
        assert run([*asked, option, str(pictures / name)]) == 2
        told = capsys.readouterr()
        assert told.err.endswith(f"{name}: cannot be written (Read-only file system).\n")
        assert told.out == ""


def test_a_batch_writes_a_json_for_each_picture_and_says_which_has_no_curve(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["curves", "--batch", str(pictures), "-o", str(tmp_path), *arguments(pictures)]) == 0
    told = capsys.readouterr()
    assert "3 images, 1 without a curve" in told.out
    assert "blank: no curve" in told.err
    ok = {p.stem: json.loads(p.read_text())["ok"] for p in tmp_path.glob("*.json")}
    assert ok == {"sheet0": True, "sheet1": True, "blank": False}


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ([], "no image was given"),
        (["lost.png"], "there is no such file"),
        (["--batch", "."], "takes -o FOLDER"),
    ],
)
def test_what_is_wrong_with_the_request_is_said(
    pictures: Path, capsys: pytest.CaptureFixture[str], asked: list[str], said: str
) -> None:
    assert run(["curves", *asked, *arguments(pictures)]) == 2
    assert said in capsys.readouterr().err


def test_a_board_in_the_sheets_plane_calibrates_the_camera(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scale = 8.0
    shown = cv2.warpPerspective(
        CalibrationBoard().image(20),
        np.array([[scale / 20, 0.0, 60.0], [0.0, scale / 20, 40.0], [0.0, 0.0, 1.0]]),
        (640, 480),
        flags=cv2.INTER_AREA,
        borderValue=255,
    )
    cv2.imwrite(str(tmp_path / "board.png"), shown)
    made = tmp_path / "optics.json"
    picture = str(tmp_path / "board.png")
    assert run(["calibrate", "camera", picture, "--clamp-px", "100,300", "-o", str(made)]) == 0
    assert load_optics(made).px_per_mm == pytest.approx(scale, rel=2e-3)
    assert made.with_suffix(".png").exists()
    assert "pixels per mm" in capsys.readouterr().out


def test_two_points_of_a_ruler_give_the_scale(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "ruler.png"), np.full((480, 640), 90, np.uint8))
    made = tmp_path / "optics.json"
    ruler = ["--ruler-px", "100,200,500,200", "--ruler-mm", "50", "--clamp-px", "80,240"]
    assert run(["calibrate", "camera", str(tmp_path / "ruler.png"), *ruler, "-o", str(made)]) == 0
    assert load_optics(made).px_per_mm == pytest.approx(8.0)


def test_the_direction_beside_a_ruler_is_used_or_found_in_each_image(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cv2.imwrite(str(tmp_path / "ruler.png"), np.full((480, 640), 90, np.uint8))
    made = tmp_path / "optics.json"
    ruler = ["--ruler-px", "100,200,500,200", "--ruler-mm", "50", "--clamp-px", "80,240"]
    picture = ["calibrate", "camera", str(tmp_path / "ruler.png"), *ruler, "-o", str(made)]
    assert run(picture) == 0
    assert "direction at the clamp is found in each image" in capsys.readouterr().err
    assert not load_optics(made).clamp_angle_known
    assert run([*picture, "--along-px", "80,340"]) == 0
    assert "direction" not in capsys.readouterr().err
    assert load_optics(made).roll_rad == pytest.approx(np.pi / 2)
    assert load_optics(made).clamp_angle_known


RULER = ["--ruler-px", "100,200,500,200", "--ruler-mm", "50", "--clamp-px", "80,240"]
MASK = [[[310, 40], [520, 40], [520, 60]]]


def recalibrated(tmp_path: Path, stated: dict[str, object]) -> list[str]:
    """Calibrate, state more in the file by hand, and return the command that does so again."""
    cv2.imwrite(str(tmp_path / "ruler.png"), np.full((480, 640), 90, np.uint8))
    made = tmp_path / "optics.json"
    again = ["calibrate", "camera", str(tmp_path / "ruler.png"), *RULER, "-o", str(made)]
    assert run(again) == 0
    made.write_text(json.dumps(json.loads(made.read_text()) | stated))
    return again


def test_a_new_calibration_takes_over_what_was_stated_by_hand_and_names_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stated = {"mask_px": MASK, "tip_px": [600, 300], "polarity": "dark", "note": "lens 2"}
    again = recalibrated(tmp_path, stated)
    assert run(again) == 0
    told = capsys.readouterr().out
    assert "taken over from the one before: polarity, mask_px and tip_px; where the camera" in told
    assert "not taken over from the one before: note\n" in told
    found = load_optics(tmp_path / "optics.json")
    assert (found.polarity, found.tip_px, found.note) == ("dark", (600, 300), None)
    assert found.mask_px is not None


def test_a_calibration_of_images_of_another_size_takes_over_no_pixels(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    again = recalibrated(tmp_path, {"tip_px": [600, 300], "bits": 12, "image_size": [1280, 960]})
    assert run(again) == 0
    told = capsys.readouterr().out
    assert (
        "taken over from the one before: bits; not taken over from the one before: tip_px" in told
    )
    found = load_optics(tmp_path / "optics.json")
    assert (found.tip_px, found.bits) == (None, 12)


def test_a_file_that_cannot_be_read_is_replaced_and_the_reason_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    again = recalibrated(tmp_path, {"masks": 1})
    assert run(again) == 0
    assert "nothing is taken over from the one before: " in capsys.readouterr().out


def test_labrigs_own_drawings_are_left_out_of_a_list_and_told_once(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("blank.png", "optics.json", "sheet.toml"):
        shutil.copy(pictures / name, tmp_path)
    recalibrated(tmp_path, {})
    drawing = tmp_path / "optics.png"
    assert drawing.exists()
    capsys.readouterr()
    assert run(["curves", str(tmp_path / "blank.png"), str(drawing)]) == 0
    told = capsys.readouterr()
    assert told.out.startswith("blank: no curve")
    assert "optics:" not in told.out
    assert told.err.count("labrig's own drawings are left out: optics.png.") == 1
    assert run(["calibrate", "camera", str(drawing), *RULER, "-o", str(tmp_path / "n.json")]) == 2
    assert "labrig's own drawings show no board" in capsys.readouterr().err


def test_the_board_is_a_pdf(tmp_path: Path) -> None:
    assert run(["calibrate", "board", "-o", str(tmp_path / "board.pdf")]) == 0
    assert (tmp_path / "board.pdf").read_bytes().startswith(b"%PDF")


def test_dead_weights_calibrate_the_load_cell_and_the_old_calibration_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_templates(tmp_path / "rig", simulated=True)
    weights = [f"--weight-mN={mN}" for mN in (0, 20, 50, 0)]
    assert run(["calibrate", "load-cell", str(tmp_path / "rig" / "rig.toml"), *weights]) == 0
    made = load_load_cell(tmp_path / "rig" / "load_cell.toml")
    assert made.sensitivity_V_per_N == pytest.approx(0.15296, rel=5e-3)
    assert 0 < made.sensitivity_sigma_V_per_N < 1e-3
    (kept,) = (tmp_path / "rig").glob("load_cell.2*.toml")
    assert f"; the one before is {kept}\n" in capsys.readouterr().out
    assert run(["calibrate", "load-cell", str(tmp_path / "rig" / "rig.toml"), "--weight-mN=0"]) == 2
    assert "at least three readings" in capsys.readouterr().err
