"""`labrig curves` where length, direction, thickness or colour channel are not stated."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from labrig.cli.main import run
from tests.labrig.vision import drawn_strips

CLAMP = drawn_strips.BENT_UP.optics.clamp_px
AHEAD = f"{CLAMP[0] + 30:g},{CLAMP[1] - 2:g}"


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    """A strip with nothing beside it but scale and clamp."""
    path = drawn_strips.write(tmp_path, drawn_strips.BENT_UP.image, clamp_angle_known=False)
    (tmp_path / "sheet.toml").unlink()
    return path


@pytest.mark.slow
@pytest.mark.parametrize("direction", [[], ["--along-px", AHEAD]])
def test_scale_and_clamp_are_enough_to_the_end(
    photo: Path, capsys: pytest.CaptureFixture[str], direction: list[str]
) -> None:
    assert run(["curves", str(photo), "--to-end", "--json", *direction]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["ok"], found["why"]
    assert drawn_strips.off_px(found["points_px"], drawn_strips.BENT_UP) < 0.5
    assert found["s_mm"][-1] == pytest.approx(30, abs=1.0)
    said = next(text for text in found["warnings"] if "not stated" in text)
    assert "length" in said
    assert ("direction" in said) == (not direction)


def test_without_a_length_or_to_end_the_missing_file_is_named(
    photo: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["curves", str(photo)]) == 2
    said = capsys.readouterr().err
    assert "sheet.toml" in said
    assert "--to-end" in said


def test_without_a_scale_the_ways_to_one_are_named(
    photo: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photo.with_name("optics.json").unlink()
    assert run(["curves", str(photo), "--to-end"]) == 2
    said = capsys.readouterr().err
    assert "labrig calibrate camera" in said
    assert "--page" in said


def test_a_stated_thickness_that_is_not_there_is_named(
    photo: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photo.with_name("sheet.toml").write_text("free_length_mm = 50\nthickness_mm = 4\n")
    assert run(["curves", str(photo), "--to-end"]) == 0
    assert "leave the thickness out to have it measured" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["--along-px", "12"], "--along-px '12': give a pixel's column and row, U,V."),
        (
            ["--along-px", f"{CLAMP[0]:g},{CLAMP[1]:g}"],
            "is the clamp itself: give a pixel further",
        ),
        (["--channel", "purple"], "purple"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    photo: Path, capsys: pytest.CaptureFixture[str], asked: list[str], said: str
) -> None:
    assert run(["curves", str(photo), "--to-end", *asked]) == 2
    assert said in capsys.readouterr().err
