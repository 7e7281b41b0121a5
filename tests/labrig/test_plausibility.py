"""Tables whose numbers can hardly be in the units that their columns name."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.config import parse_sheet
from labrig.plausibility import calibration_age
from labrig.session import load_measurements
from labrig.session.tables import read_tables

SHEET = """
free_length_mm = 50.0
width_mm = 11.0
thickness_mm = 0.21
elongation_mm = 10.0
[arc]
radius_mm = 40.0
"""
FUTURE = "dated in the future (2026-07-03; this computer's clock says 2026-07-01)"
LOADS = [(p, v, f) for p in (0.0, 15.0, 30.0) for v, f in ((0.0, 0.3), (2.0, 2.1))]


def imported(
    folder: Path,
    position: float = 1.0,
    voltage: float = 1.0,
    force: float = 1.0,
    shape: float = 1.0,
) -> Path:
    """A session of good tables whose columns were multiplied."""
    (folder / "sheet.toml").write_text(SHEET)
    lines = [
        f"sheet,{position * p},{voltage * v},{i},{force * f}" for i, (p, v, f) in enumerate(LOADS)
    ]
    header = "configuration,position_mm,voltage_V"
    (folder / "forces.csv").write_text("\n".join([f"{header},reading,force_mN", *lines]) + "\n")
    points = [
        f"sheet,{position * 15},{voltage * 2},{k},{shape * 12 * k},{shape * k * k / 5}"
        for k in range(6)
    ]
    (folder / "curves.csv").write_text("\n".join([f"{header},point,x_mm,y_mm", *points]) + "\n")
    files = [f"--{name}={folder / name}.csv" for name in ("forces", "curves")]
    out = folder / "session.h5"
    assert run(["import", f"--sheet={folder / 'sheet.toml'}", *files, "-o", str(out)]) == 0
    return out


def test_good_tables_are_taken_without_a_word(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert load_measurements(imported(tmp_path)).warnings == ()
    assert "warning" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("column", "factor", "asked"),
    [
        ("force", 1e-3, "is force_mN in mN?"),
        ("force", 1e3, "The forces reach 2100 mN: is force_mN in mN?"),
        ("position", 1e-3, "is position_mm in mm?"),
        ("voltage", 1e3, "The voltages reach 2000 V: is voltage_V in V?"),
        ("voltage", 1e-3, "is voltage_V in V?"),
        ("shape", 1e-3, "are x_mm and y_mm in mm?"),
        ("shape", 10.0, "are x_mm and y_mm in mm?"),
    ],
)
def test_another_unit_is_asked_about_and_the_question_stays_with_the_session(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], column: str, factor: float, asked: str
) -> None:
    warnings = load_measurements(imported(tmp_path, **{column: factor})).warnings
    assert len(warnings) == 1
    assert warnings[0].endswith(asked)
    assert f"warning: {warnings[0]}" in capsys.readouterr().err


def test_a_thickness_in_metres_is_asked_about(tmp_path: Path) -> None:
    (tmp_path / "sheet.toml").write_text(SHEET.replace("= 0.21", "= 0.00021"))
    (tmp_path / "forces.csv").write_text(f"{FORCES}sheet,0,2,0,2.1\n")
    sheets = parse_sheet((tmp_path / "sheet.toml").read_text(), "sheet.toml")
    assert read_tables(sheets, tmp_path / "forces.csv", None).warnings == (
        "sheet.toml [sheet] thickness_mm is 0.00021 mm, usual is 0.01 to 3 mm: is its unit right?",
    )


FORCES = "configuration,position_mm,voltage_V,reading,force_mN\n"


def said_of(folder: Path, forces: str, curves: str | None = None) -> tuple[str, ...]:
    """What is said of two tables."""
    (folder / "forces.csv").write_text(FORCES + forces)
    if curves is not None:
        (folder / "curves.csv").write_text(
            "configuration,position_mm,voltage_V,x_mm,y_mm\n" + curves
        )
    sheets = parse_sheet(SHEET, "sheet.toml")
    return read_tables(
        sheets, folder / "forces.csv", None if curves is None else folder / "curves.csv"
    ).warnings


@pytest.mark.parametrize("column", ["voltage_V", "position_mm"])
def test_what_was_measured_in_place_of_what_was_set_is_asked_about(
    tmp_path: Path, column: str
) -> None:
    off = {"voltage_V": 0.0, "position_mm": 0.0, column: 1e-3}
    lines = [
        f"sheet,{p + off['position_mm'] * k},{v + off['voltage_V'] * k},{k},{f}\n"
        for p, v, f in LOADS
        for k in range(4)
    ]
    (said,) = said_of(tmp_path, "".join(lines))
    groups = 2 if column == "voltage_V" else 3
    assert said.startswith(f"{column} has {4 * groups} values in {groups} groups: was it measured?")


def test_a_staircase_of_small_steps_is_no_measured_voltage(tmp_path: Path) -> None:
    assert said_of(tmp_path, "".join(f"sheet,0,{k / 20},0,{k / 30}\n" for k in range(20))) == ()


@pytest.mark.parametrize(("x", "y"), [(20, 10), (-40, 0), (0, -30)])
def test_curves_that_begin_elsewhere_than_at_the_clamp_are_asked_about(
    tmp_path: Path, x: float, y: float
) -> None:
    points = [(12 * k, k * k / 5) for k in range(6)]
    forces = "".join(f"sheet,{p},{v},0,{f}\n" for p, v, f in LOADS)
    for dx, dy, asked in ((0, 0, []), (3, 2, []), (x, y, [f"x = {x} mm, y = {y} mm"])):
        curve = "".join(f"sheet,15,2,{a + dx},{b + dy}\n" for a, b in points)
        said = said_of(tmp_path, forces, curve)
        assert len(said) == len(asked)
        assert all(text in one for text, one in zip(asked, said, strict=True))


@pytest.mark.parametrize(
    ("date", "ok", "warning", "found"),
    [
        ("2026-06-01", True, False, "30 days old"),
        ("2026-01-01", True, True, "181 days old"),
        ("2026-07-02", True, False, "0 days old"),  # today, in a time zone to the east
        ("2026-07-03", False, False, FUTURE),
        ("1970-01-01", True, True, "never made: labrig init's"),
    ],
)
def test_an_old_calibration_is_a_warning_and_one_from_the_future_a_fault(date, ok, warning, found):
    today = dt.date(2026, 7, 1)
    check = calibration_age("load cell calibration", dt.date.fromisoformat(date), 180, today)
    assert (check.ok, check.warning, check.found) == (ok, warning, found)
