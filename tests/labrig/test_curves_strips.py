"""`labrig curves` with masks, with several strips in a picture, and with other methods."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from drivers.plugins import Part
from labrig.cli.main import run
from labrig.extractors import choice
from labrig.vision import load_optics
from labrig.vision.image.downscaling import downscaled_optics
from tests.labrig.vision import drawn_strips

SECOND = drawn_strips.over_reflection()
AS_TEXT = " ".join(f"{u},{v}" for u, v in SECOND)
CLAMP = drawn_strips.BENT_UP.optics.clamp_px
FIRST_STRIP = f"left={CLAMP[0]:g},{CLAMP[1]:g}"
SECOND_STRIP = f"right={CLAMP[0] + 200:g},{CLAMP[1]:g}:{CLAMP[0] + 230:g},{CLAMP[1]:g}"


def told(capsys: pytest.CaptureFixture[str]) -> list[dict[str, object]]:
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


@pytest.mark.slow
def test_what_confuses_is_masked_on_the_command_line_in_a_file_and_in_optics_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photo = drawn_strips.write(tmp_path, drawn_strips.with_reflection())
    assert run(["curves", str(photo), "--json"]) == 0
    assert "two sheets" in str(told(capsys)[0]["why"])
    (tmp_path / "mask.json").write_text(json.dumps([SECOND]))
    for mask in (AS_TEXT, str(tmp_path / "mask.json")):
        assert run(["curves", str(photo), "--json", "--mask", mask]) == 0
        (found,) = told(capsys)
        assert found["ok"], found["why"]
        assert drawn_strips.off_px(found["points_px"], drawn_strips.BENT_UP) < 0.3
    drawn_strips.write(tmp_path, drawn_strips.with_reflection(), mask_px=[SECOND])
    assert run(["curves", str(photo), "--json"]) == 0
    assert told(capsys)[0]["points_px"] == found["points_px"]


def test_a_strip_under_the_mask_is_hidden(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photo = drawn_strips.write(tmp_path, drawn_strips.BENT_UP.image)
    all_of_it = "0,0 199,0 199,149 0,149"
    assert run(["curves", str(photo), "--json", "--mask", all_of_it]) == 0
    (found,) = told(capsys)
    assert "masks or rolls hide all of it" in str(found["why"])


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["--mask", "1,2 3,4"], "--mask '1,2 3,4': is no mask; give a JSON file"),
        (["--mask", "no.json"], "no.json: there is no such file"),
        (["--strip", "left"], "--strip 'left': give NAME=U,V"),
        (["--strip", "a=1,2", "--strip", "a=3,4"], "there is a strip 'a' already"),
        (["--strip", "a=1,2:1,2"], "along_px must be another pixel"),
        (["--method", "intensity_fit"], "cannot be compared with itself"),
        (["--method", "ridges"], "--method: there is no curve extractor 'ridges'"),
        (["--method", "list", "--summary", "x.csv"], "leave --batch, --summary, --overlay"),
    ],
)
def test_a_wrong_mask_strip_or_method_is_one_sentence(
    tmp_path: Path, asked: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    photo = drawn_strips.write(tmp_path, drawn_strips.BENT_UP.image)
    assert run(["curves", str(photo), *asked]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.slow
def test_several_strips_of_a_picture_have_a_curve_each(tmp_path: Path) -> None:
    photo = drawn_strips.write(tmp_path, drawn_strips.side_by_side())
    out = tmp_path / "out"
    strips = ["--strip", FIRST_STRIP, "--strip", SECOND_STRIP]
    assert run(["curves", "--batch", str(tmp_path), "-o", str(out), *strips]) == 0
    found = {p.stem: json.loads(p.read_text()) for p in out.glob("*.json")}
    assert {stem: each["strip"] for stem, each in found.items()} == {
        "photo_left": "left",
        "photo_right": "right",
    }
    examples = (("left", drawn_strips.BENT_UP, 0.0), ("right", drawn_strips.BENT_DOWN, 200.0))
    for strip, example, shift_px in examples:
        points = found[f"photo_{strip}"]["points_px"]
        assert drawn_strips.off_px(points, example, shift_px) < 0.3
        # its own coordinates begin at its own clamp
        assert abs(found[f"photo_{strip}"]["x_mm"][0]) < 0.5
    rows = list(csv.DictReader((out / "summary.csv").read_text().splitlines()))
    assert [(row["image"], row["strip"]) for row in rows] == [
        ("photo:left", "left"),
        ("photo:right", "right"),
    ]
    assert (out / "photo_left_curve.png").exists()
    assert photo.exists()


@pytest.mark.slow
def test_the_overlay_of_a_picture_has_all_its_strips_and_is_of_one_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photo = drawn_strips.write(tmp_path, drawn_strips.side_by_side())
    overlay, table = tmp_path / "o.png", tmp_path / "c.csv"
    asked = ["--strip", FIRST_STRIP, "--strip", SECOND_STRIP, "--overlay", str(overlay)]
    assert run(["curves", str(photo), *asked, "-o", str(table)]) == 0
    drawing = cv2.imread(str(overlay))
    red = (drawing[..., 2] > 200) & (drawing[..., 1] < 120)
    half = drawing.shape[1] // 2
    assert red[:, :half].sum() > 100
    assert red[:, half:].sum() > 100
    assert {row["strip"] for row in csv.DictReader(table.read_text().splitlines())} == {
        "left", "right",
    }  # fmt: skip
    overlay.unlink()
    capsys.readouterr()
    for several in ([str(photo), str(photo)], [str(tmp_path)]):
        assert run(["curves", *several, "--overlay", str(overlay)]) == 2
        assert capsys.readouterr().out == ""  # nothing was measured
    assert run(["curves", str(photo), "-o", str(tmp_path / "no" / "c.csv")]) == 2
    assert "no: there is no such folder" in capsys.readouterr().err
    assert not overlay.exists()


@pytest.mark.slow
def test_strips_stand_in_optics_json_and_take_their_tables_of_sheet_toml(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    strips = {"left": {"clamp_px": CLAMP}, "right": {"clamp_px": (CLAMP[0] + 200, CLAMP[1])}}
    photo = drawn_strips.write(tmp_path, drawn_strips.side_by_side(), strips=strips)
    table = "free_length_mm = {}\nthickness_mm = 0.6\n"
    (tmp_path / "sheet.toml").write_text(
        "[left]\n" + table.format(30) + "[right]\n" + table.format(20)
    )
    assert run(["curves", str(photo), "--json"]) == 0
    left, right = told(capsys)
    assert left["ok"], left["why"]
    assert left["s_mm"][-1] == pytest.approx(30.0)  # type: ignore[index]
    assert not right["ok"]  # it is 30 mm long, not 20
    assert "20.0 mm" in str(right["why"])


@pytest.mark.slow
def test_a_strips_name_that_would_overwrite_another_images_curve_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drawn_strips.write(tmp_path, drawn_strips.BENT_UP.image, "photo")
    drawn_strips.write(tmp_path, drawn_strips.BENT_UP.image, "photo_a")
    asked = ["curves", "--batch", str(tmp_path), "-o", str(tmp_path / "out")]
    strips = ["--strip", f"a_a={CLAMP[0]},{CLAMP[1]}", "--strip", f"a={CLAMP[0]},{CLAMP[1]}"]
    assert run([*asked, *strips]) == 2
    assert "would be written over photo_a_a.json" in capsys.readouterr().err


def test_masks_and_strips_survive_a_reduced_image() -> None:
    optics = drawn_strips.BENT_UP.optics.model_copy(update={"mask_px": (((0.5, 0.5),) * 3,)})
    assert downscaled_optics(optics, 2).mask_px == (((0.0, 0.0),) * 3,)


class Shifted:
    """The built-in curve, moved by half a pixel down."""

    summary = "Move the built-in curve."

    def curve(self, image, optics, strip, *, start=None):  # type: ignore[no-untyped-def]
        from dataclasses import replace

        found = choice.EXTRACTORS.get(choice.BUILT_IN).curve(image, optics, strip, start=start)
        return replace(found, points_px=np.add(found.points_px, (0.0, 0.5))) if found.ok else found


@pytest.fixture
def shifted(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = choice.EXTRACTORS.parts() | {"shifted": Part("shifted", Shifted(), "labrig-extra", "1")}
    folder = type(
        "Folder", (), {"parts": lambda _: parts, "get": lambda _, name: parts[name].part}
    )()
    monkeypatch.setattr(choice, "EXTRACTORS", folder)


@pytest.mark.usefixtures("shifted")
def test_one_extractor_is_run_against_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drawn_strips.write(tmp_path, drawn_strips.BENT_UP.image, "strip")
    drawn_strips.write(tmp_path, drawn_strips.BENT_UP.image // 3 * 0 + 90, "without")
    kept = tmp_path / "compared.csv"
    assert run(["curves", str(tmp_path), "--method", "shifted", "-o", str(kept)]) == 0
    said = capsys.readouterr().out
    assert "intensity_fit: 1 curves, 1 refused" in said
    assert "shifted: 1 curves, 1 refused, 0.4" in said
    rows = list(csv.DictReader(kept.read_text().splitlines()))
    assert [(row["image"], row["method"], row["state"]) for row in rows] == [
        ("strip", "intensity_fit", "found"),
        ("strip", "shifted", "found"),
        ("without", "intensity_fit", "refused"),
        ("without", "shifted", "refused"),
    ]
    assert 0.3 < float(rows[1]["apart_rms_px"]) <= 0.5
    assert float(rows[1]["tip_apart_px"]) == pytest.approx(0.5, abs=1e-3)
    assert rows[2]["reason"]


@pytest.mark.usefixtures("shifted")
def test_the_extractors_are_listed_with_where_they_come_from(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["curves", "--method", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("intensity_fit (labrig): Search the image")
    assert lines[1] == "shifted (labrig-extra 1): Move the built-in curve."


def test_optics_with_strips_are_read_and_written(tmp_path: Path) -> None:
    strips = {"a": {"clamp_px": (1.0, 2.0), "along_px": (1.0, 52.0)}}
    drawn_strips.write(tmp_path, drawn_strips.BENT_UP.image, strips=strips)
    optics = load_optics(tmp_path / "optics.json")
    again = type(optics).from_json(optics.to_json())
    assert again == optics
    turned = optics.by_strip()["a"]
    assert turned.strips is None
    # the strip leaves its clamp downwards
    assert turned.world_to_pixel([[0.01, 0.0]])[0] == pytest.approx([1.0, 42.0])
