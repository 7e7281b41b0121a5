"""`labrig design`: the questions of the paper's section 5 from the command line."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import labrig
from labrig.cli.main import run
from labrig.model_file import load_model, save_model
from labrig.report.design.answers import tables
from model import Along, ConfiguredSheet, Parameter, SheetGeometry, SheetModel

pytestmark = pytest.mark.slow


@pytest.fixture
def model_file(tmp_path: Path) -> Path:
    """A short sheet with an elongation, nearly straight, driven both ways alike."""
    sheet = SheetGeometry(
        configuration="short",
        free_length_m=4.5e-3,
        width_m=11e-3,
        thickness_m=0.21e-3,
        elongation_m=40e-3,
        arc_radius_m=40e-3,
        arc_origin_rad=0.0,
        initial_curvature=None,
    )
    s = np.array([0.0, 4.5e-3])
    zero = np.zeros(2)
    B = 8.5e-7
    one = ConfiguredSheet(
        sheet=sheet,
        B=Parameter(value=B, sigma=0.01 * B, unit="N m^2"),
        rest=Along(s, np.full(2, 28.0), zero, "1/m"),
        eibm={
            2.0: Along(s, np.full(2, 7e-5), np.full(2, 7e-7), "N m"),
            -2.0: Along(s, np.full(2, -5.6e-5), np.full(2, 6e-7), "N m"),
        },
    )
    path = tmp_path / "model.toml"
    save_model(SheetModel(sheets={"short": one}), path)
    return path


def test_every_question_is_answered_with_its_uncertainty(
    model_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["design", str(model_file), "--section", "0:12", "--force-mN", "0.5", "--json"]
    assert run(arguments) == 0
    (found,) = json.loads(capsys.readouterr().out)
    lines = {line["voltage_V"]: line for line in found["lines"]}
    assert set(lines) == {-2.0, 0.0, 2.0}
    # The paper: the short sheet's F(p) is a line within 1 %, its slope free of the voltage.
    assert all(line["relative_error"] < 0.01 for line in lines.values())
    slopes = [line["slope_N_per_m"]["value"] for line in lines.values()]
    assert max(slopes) / min(slopes) == pytest.approx(1.0, abs=0.02)
    assert lines[0.0]["slope_N_per_m"]["sigma"] == pytest.approx(-0.01 * slopes[1], rel=0.2)
    assert found["least_area"]["with elongation"]["area_m2"]["value"] > 0
    assert found["unanswered"] == {} or "without elongation" in found["unanswered"]


@pytest.mark.thorough
def test_tables_and_figures_are_made(
    model_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "figures"
    assert run(["design", str(model_file), "--section", "0:12", "-o", str(folder)]) == 0
    printed = capsys.readouterr().out
    for start in ("1. short: the best line", "2. shapes", "3. shortest", "4. largest", "5. force"):
        assert start in printed
    assert {path.stem for path in folder.iterdir()} == {
        f"short-{name}" for name in ("forces", "shapes", "reach", "linear", "elongation")
    }


def test_a_question_without_an_answer_takes_no_other_along(
    model_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A sheet that ends short of the section's end: a longer one of its material would do."""
    text = model_file.read_text()
    model_file.write_text(text.replace("elongation_mm = 40.0", "elongation_mm = 35.0"))
    arguments = ["design", str(model_file), "--section", "0:30", "-o", str(tmp_path / "figures")]
    assert run([*arguments, "--json"]) == 0
    printed = capsys.readouterr()
    (found,) = json.loads(printed.out)
    assert found["shortest_length_m"]["value"] > 0.04
    assert found["lines"] == []
    assert found["controller"] is None
    assert "not reachable everywhere" in found["unanswered"]["largest forces"]
    said = printed.err.strip().splitlines()
    assert len(said) == len(set(found["unanswered"].values()))
    assert any("no answer to" in line and "largest forces" in line for line in said)
    assert {path.stem for path in (tmp_path / "figures").iterdir()} == {
        "short-reach",
        "short-elongation",
    }


def test_a_section_far_out_of_reach_has_no_empty_table_and_no_false_digits() -> None:
    long = labrig.sheet(
        free_length_mm=50, width_mm=11, thickness_mm=0.21, B_Nm2=1.27e-6,
        EIBM_Nm={2.0: 36e-6, -2.0: -36e-6}, initial_curvature_per_m=14,
    )  # fmt: skip
    (found,) = labrig.design(long, (-20, 51))
    told = " ".join([*found.unanswered, *found.unanswered.values()])
    assert "+0 V" not in told
    assert not re.search(r"\d\.\d{3,} mm", told)
    bare = replace(found, shapes=None, reach=None, largest={}, both_ways=None)
    assert not any(table.title.startswith("2-5.") for table in tables(bare))


def test_a_model_along_the_sheet_that_misses_its_data_is_not_told_to_be_along_it(
    model_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = load_model(model_file)
    one = model.sheet("short")
    falling = np.array([1.0, 0.5])
    eibm = {v: replace(a, values=a.values * falling) for v, a in one.eibm.items()}
    merit = {"force_rmse_N": 5e-4, "curve_rmse_m": 1.8e-3, "force_rms_N": 1e-3}
    varying = replace(model, sheets={**model.sheets, "short": replace(one, eibm=eibm)})
    save_model(varying.with_merit(merit, {"short": merit}), model_file, force=True)
    assert run(["simulate", str(model_file), "--position-mm", "5", "--voltage", "2"]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "misses its own data by 0.500 mN and 1.800 mm RMS; labrig diagnose says" in told
    assert "--varying" not in told


def test_a_model_that_misses_its_own_data_is_warned_of(
    model_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = load_model(model_file)
    merit = {"force_rmse_N": 5e-4, "curve_rmse_m": 1.8e-3, "force_rms_N": 1e-3}
    merit |= {"force_rmse_along_N": 2e-5, "curve_rmse_along_m": 3e-5}
    save_model(model.with_merit(merit, {"short": merit}), model_file, force=True)
    assert run(["design", str(model_file), "--section", "0:12"]) == 0
    printed = capsys.readouterr()
    assert "the model of 'short' misses its own data by 0.500 mN and 1.800 mm" in printed.err
    assert "along the sheet, 0.020 mN and 0.030 mm" in printed.err
    assert "RMS: short 0.500 mN and 1.800 mm" in printed.out
    arguments = ["simulate", str(model_file), "--position-mm", "5", "--voltage", "2"]
    assert run(arguments) == 0
    assert "misses its own data" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ("0-12", "two positions in mm"),
        ("12:0", "first position must be below the second"),
        ("0:160", "beyond half the circle"),
    ],
)
def test_a_section_that_is_none_is_told_in_a_sentence(
    model_file: Path, capsys: pytest.CaptureFixture[str], section: str, said: str
) -> None:
    assert run(["design", str(model_file), "--section", section]) == 2
    assert said in capsys.readouterr().err


def test_a_model_without_a_driving_voltage_is_told_to_have_none(
    model_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = load_model(model_file)
    still = replace(model, sheets={"short": replace(model.sheet("short"), eibm={})})
    save_model(still, model_file, force=True)
    assert run(["design", str(model_file), "--section", "0:12"]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "no answer to linear model: the model of 'short' has no driving voltage" in told
