"""Numbers of a set-up that can hardly be meant: asked about by `plan`, `check` and `run`."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.config.templates import write_templates
from labrig.experiment.preflight import doubts, plan_of

Edit = Callable[[Path], None]


def edit(file: str, *changes: tuple[str, str]) -> Edit:
    def apply(folder: Path) -> None:
        text = (folder / file).read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (folder / file).write_text(text)

    return apply


POSITIONS = "[0, 5, 10, 15, 20, 25, 30]"
FAULTS = [
    (edit("sheet.toml", ("radius_mm = 40.0", "radius_mm = 0.04")), "[arc] radius_mm: 0.04 mm"),
    (edit("sheet.toml", ("= 50.0", "= 0.05")), "[long] free_length_mm: 0.05 mm"),
    (edit("sheet.toml", ("width_mm = 11.0", "width_mm = 0.011")), "[long] width_mm: 0.011 mm"),
    (edit("sheet.toml", ("= 0.21", "= 0.00021")), "[short] thickness_mm: 0.00021 mm"),
    (edit("sheet.toml", ("= 50.0", "= 3.0")), "sheet and elongation: 0.075"),
    (edit("sheet.toml", ("elongation_mm = 40.0", "elongation_mm = 0.04")), "elongation_mm: 0.04"),
    (edit("sheet.toml", ("= 1.5", "= 0.0015")), "clamped_length_mm: 0.0015 mm"),
    (edit("sheet.toml", ("rise_time_s = 0.03", "rise_time_s = 30")), "rise_time_s: 30 s"),
    (edit("sheet.toml", ("= 28.0", "= 28000.0")), "initial_curvature_per_m: "),
    (edit("protocol.toml", (POSITIONS, "[0, 15000]")), "positions_mm: 15000 mm, wanted -126 to"),
    (edit("protocol.toml", (POSITIONS, "[0, 0.005, 0.03]")), "to the last: 0.03 mm"),
    (edit("load_cell.toml", ("= 98.07", "= 0.09807")), "sensitivity_V_per_N times capacity"),
    (edit("load_cell.toml", ("= 0.15296", "= 152.96")), "sensitivity_V_per_N times capacity"),
    (edit("optics.json", ("7.001", "7001")), "px_per_mm, the sheet in the image: "),
    (edit("optics.json", ("7.001", "0.007")), "px_per_mm, the sheet in the image: 0.35 pixels"),
    (
        edit("protocol.toml", ('mode = "paper"', "dead_weights_mN = [5000.0]")),
        "dead_weights_mN: 5000 mN, wanted at most the load cell's 98.07 mN",
    ),
]
FILES = ("rig.toml", "protocol.toml", "sheet.toml")


@pytest.mark.parametrize(("spoil", "told"), FAULTS)
def test_a_number_that_nobody_can_mean_starts_no_experiment(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], spoil: Edit, told: str
) -> None:
    write_templates(tmp_path, simulated=True)
    spoil(tmp_path)
    session = tmp_path / "session.h5"
    assert run(["run", *(str(tmp_path / name) for name in FILES), "-o", str(session)]) == 2
    assert told in capsys.readouterr().err
    assert not session.exists()


@pytest.mark.slow
def test_the_preflight_fails_with_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_templates(tmp_path, simulated=True)
    FAULTS[0][0](tmp_path)
    assert run(["check", str(tmp_path / "rig.toml")]) == 3
    shown = capsys.readouterr()
    assert "radius_mm" in shown.out
    assert "radius_mm: 0.04 mm, wanted " in shown.err


def test_the_plan_warns_of_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_templates(tmp_path, simulated=True)
    edit("protocol.toml", (POSITIONS, "[0, 15000]"))(tmp_path)
    assert run(["plan", str(tmp_path / "protocol.toml")]) == 0
    told = capsys.readouterr().err
    assert "warning: protocol.toml [[places]] long positions_mm: 15000 mm" in told


def test_the_plan_warns_of_what_the_rig_beside_it_refuses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_templates(tmp_path, simulated=True)
    assert run(["plan", str(tmp_path / "protocol.toml")]) == 0
    assert "rig.toml" not in capsys.readouterr().err
    rig = tmp_path / "rig.toml"
    text = rig.read_text(encoding="utf-8")
    text = re.sub(r"(?m)^sheet_voltage_V = [0-9.]+", "sheet_voltage_V = 1.5", text)
    rig.write_text(text, encoding="utf-8")
    assert run(["plan", str(tmp_path / "protocol.toml")]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "warning: rig.toml beside it: run 1 (long at 0 mm) and 13 more:" in told
    assert "2 V at the sheet is beyond the limit of ±1.5 V ([limits] sheet_voltage_V)" in told
    assert "; labrig run will refuse this." in told
    rig.write_text("no table", encoding="utf-8")  # what is wrong with it is said by check and run
    assert run(["plan", str(tmp_path / "protocol.toml")]) == 0
    assert "rig.toml" not in capsys.readouterr().err


def test_what_is_unusual_is_a_warning(tmp_path: Path) -> None:
    write_templates(tmp_path, simulated=True)
    edit("sheet.toml", ("= 0.21", "= 4.0"))(tmp_path)
    found = doubts(plan_of(tmp_path / "rig.toml"))
    assert [(check.ok, check.warning) for check in found] == [(True, True)] * 2


def test_a_limit_that_no_sheet_in_water_stands_is_a_warning(tmp_path: Path) -> None:
    write_templates(tmp_path, simulated=True)
    edit("rig.toml", ("sheet_voltage_V = 2.5", "sheet_voltage_V = 25"))(tmp_path)
    (found,) = doubts(plan_of(tmp_path / "rig.toml"))
    assert (found.ok, found.warning) == (True, True)
    assert found.in_words == "rig.toml [limits] sheet_voltage_V: 25 V, wanted 0.02 to 6 V"


@pytest.mark.parametrize("simulated", [True, False])
def test_the_shipped_files_are_taken_without_a_word(tmp_path: Path, *, simulated: bool) -> None:
    write_templates(tmp_path, simulated=simulated)
    assert doubts(plan_of(tmp_path / "rig.toml")) == []
