"""`labrig simulate --time`: what it writes, against exact motions, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.model_file import save_model
from tests.cases import few
from tests.labrig.moving_model import model

pytestmark = pytest.mark.slow

TABLES = Path(__file__).parents[1] / "data" / "reference" / "dynamics"
PULSES = "time_s,voltage_V\n0.1,2\n0.7,-2\n1.0,0\n"
SCALARS = ["time_s", "drive_V", "sheet_V", "current_A"]
SCALARS += ["force_N", "normal_N", "s_hat_m", "phi_hat_rad"]
PROTOCOL = """
[pulse_train]
zero_readings = 2
readings_per_voltage = 2

[[places]]
configuration = "long"
positions_mm = [5]

[extras]
mode = "paper"
"""
EXTRAS = "release = true\nchirp = true\nload_cell_step = true"
WITH_EXTRAS = PROTOCOL.replace('mode = "paper"', EXTRAS)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    save_model(model(), tmp_path / "model.toml")
    (tmp_path / "drive.csv").write_text(PULSES)
    (tmp_path / "protocol.toml").write_text(PROTOCOL)
    (tmp_path / "extras.toml").write_text(WITH_EXTRAS)
    return tmp_path


def labrig(*arguments: object) -> int:
    return run([str(argument) for argument in arguments])


def motion(
    folder: Path, *options: object, file: str = "motion.h5", drive: str = "drive.csv"
) -> int:
    output = ["-o", folder / file] if file else []
    given = ["--drive", folder / drive] if drive else []
    return labrig("simulate", folder / "model.toml", "--time", *given, *output, *options)


@pytest.mark.parametrize(
    ("table", "options"),
    few(
        [
            ("contact_p0", ["--position-mm", 0]),
            ("contact_p15", ["--position-mm", 15]),
            ("free", []),
        ]
    ),
)
def test_the_table_of_a_motion_is_the_exact_one(
    tmp_path: Path, table: str, options: list[object]
) -> None:
    save_model(model(fluid="vacuum", points=401), tmp_path / "model.toml")
    (tmp_path / "drive.csv").write_text(PULSES)
    wanted = np.genfromtxt(TABLES / f"x_pulse_{table}.csv", delimiter=",", names=True)
    assert motion(tmp_path, "--every-ms", 0.5, *options, file="motion.csv") == 0
    with (tmp_path / "motion.csv").open() as file:
        header = file.readline().strip().split(",")
        rows = np.genfromtxt(file, delimiter=",")
    assert header[:8] == SCALARS
    found = dict(zip(header, rows.T, strict=True))
    assert rows.shape == (2001, len(SCALARS) + 3 * 21 + 1)
    at = np.searchsorted(found["time_s"], wanted["t_s"] - 1e-9)
    assert found["force_N"][at] == pytest.approx(wanted["F_N"], abs=3e-6)
    assert found["reading_N"] == pytest.approx(found["force_N"])
    assert found["x_m[20]"][at] == pytest.approx(wanted["tip_x_m"], abs=3e-6)
    assert found["y_m[20]"][at] == pytest.approx(wanted["tip_y_m"], abs=3e-6)
    assert found["current_A"][at] == pytest.approx(wanted["current_A"], abs=1e-9)
    if options:
        assert found["s_hat_m"][at] == pytest.approx(wanted["s_hat_m"], abs=3e-6)
    else:
        assert np.all(np.isnan(found["s_hat_m"]))


def test_it_begins_with_the_force_of_the_sheet_at_rest(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = ["--position-mm", 5]
    assert labrig("simulate", folder / "model.toml", *place, "--voltage", 0, "--json") == 0
    (rest,) = json.loads(capsys.readouterr().out)
    assert motion(folder, *place) == 0
    with h5py.File(folder / "motion.h5") as file:
        data = file["entry/motion"]
        assert data["force_N"][0] == pytest.approx(rest["F_N"], rel=1e-6)
        assert data["s_hat_m"][0] == pytest.approx(1e-3 * rest["s_hat_mm"], rel=1e-6)


def test_hdf5_holds_two_plots_that_nexus_readers_find(folder: Path) -> None:
    assert motion(folder, "--position-mm", 5, "--every-ms", 2, "--start", 100) == 0
    with h5py.File(folder / "motion.h5") as file:
        entry = file[file.attrs["default"]]
        data = entry[entry.attrs["default"]]
        assert data.attrs["NX_class"] == "NXdata"
        assert data.attrs["signal"] == "force_N"
        assert list(data.attrs["axes"]) == ["time_s"]
        assert data["time_s"][:] == pytest.approx(np.arange(0.1, 1.0001, 0.002))
        assert data["force_N"].attrs["units"] == "N"
        assert {data[name].shape for name in SCALARS} == {(451,)}
        shape = entry["shape"]
        assert list(shape.attrs["axes"]) == ["time_s", "s_m"]
        assert {shape[name].shape for name in ("x_m", "y_m", "curvature_per_m")} == {(451, 21)}
        assert shape["s_m"][-1] == 0.05
        assert shape["curvature_per_m"].attrs["units"] == "1/m"
        made = entry["simulation"]
        assert made["configuration"][()] == b"long"
        assert made["position_m"][()] == 0.005
        assert made["drive_file"][()] == b"drive.csv"


def test_a_protocol_drives_it_with_its_own_pulses_and_readings(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert motion(folder, "--position-mm", 5, drive="protocol.toml") == 0
    assert labrig("plan", folder / "protocol.toml", "--json") == 0
    printed = capsys.readouterr().out
    planned = json.loads(printed[printed.index("{") :])["runs"][0]
    lines = {line.split("  ")[0]: line.split() for line in printed.splitlines()}
    with h5py.File(folder / "motion.h5") as file:
        data = {name: file["entry/motion"][name][:] for name in SCALARS}
    assert data["time_s"][-1] == pytest.approx(planned["duration_s"])
    for step, after in zip(planned["steps"], planned["steps"][1:], strict=False):
        within = (data["time_s"] > step["time_s"] + 1e-6) & (data["time_s"] < after["time_s"])
        assert set(data["drive_V"][within]) == {step["voltage_V"]}
    for volts, label in ((2.0, "+2 V"), (-2.0, "-2 V")):
        taken = [r for r in planned["readings"] if r["voltage_V"] == volts and r["kind"] == "kept"]
        times = [planned["steps"][r["step"]]["time_s"] + r["delay_s"] for r in taken]
        mean = np.mean(np.interp(times, data["time_s"], data["force_N"]))
        row = lines[f"sampling points at {label}"]
        assert row[row.index("of") + 1] == str(len(taken))
        assert float(row[-4]) == pytest.approx(1e3 * mean, abs=6e-4)
    peak = np.max(np.abs(data["force_N"]))
    assert abs(float(lines["largest force"][-4])) == pytest.approx(1e3 * peak, abs=6e-4)
    assert "wrote" in printed


def test_sampling_points_are_as_good_where_few_rows_are_written(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def said(every_ms: float) -> str:
        options = ["--position-mm", 5, "--every-ms", every_ms, "--force"]
        assert motion(folder, *options, drive="protocol.toml") == 0
        printed = capsys.readouterr().out
        return next(line for line in printed.splitlines() if "sampling points at +2 V" in line)

    assert said(70.0).split()[5:] == said(1.0).split()[5:]


def test_runs_that_extras_add_have_their_own_place(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert labrig("plan", folder / "extras.toml", "--json") == 0
    runs = json.loads(capsys.readouterr().out)["runs"]
    number = {run["extra"]: i for i, run in enumerate(runs, 1) if run.get("extra")}
    assert motion(folder, "--run", number["release"], drive="extras.toml") == 0
    with h5py.File(folder / "motion.h5") as file:
        assert "position_m" not in file["entry/simulation"]
        free = {name: file["entry/motion"][name][:] for name in ("time_s", "drive_V", "force_N")}
        tip = file["entry/shape/y_m"][:, -1]
    assert not free["force_N"].any()
    assert set(free["drive_V"]) == {0.0, 2.0}
    let_go = free["time_s"][free["drive_V"] == 2.0][-1]
    swing = tip[free["time_s"] > let_go]
    assert np.ptp(swing) > 0.01  # it springs back, and swings
    assert motion(folder, "--run", number["chirp"], "--force", drive="extras.toml") == 0
    with h5py.File(folder / "motion.h5") as file:
        assert file["entry/simulation/position_m"][()] == 0.005
        assert len(set(file["entry/motion/drive_V"][:])) > 100
    capsys.readouterr()
    assert motion(folder, "--run", number["load_cell_step"], "--force", drive="extras.toml") == 2
    assert "the load cell moves in this run" in capsys.readouterr().err


def refused(capsys: pytest.CaptureFixture[str]) -> str:
    error = capsys.readouterr().err.strip()
    assert len(error.splitlines()) == 1
    assert error.endswith(".")
    return error


@pytest.mark.parametrize(
    ("options", "words"),
    few(
        [
            (["--voltage", 2], "--voltage is of the sheet at rest"),
            (["--session", 1], "--session is of the sheet at rest"),
            (["--json"], "--json is of the sheet at rest"),
            (["--position-mm", 5, "--position-mm", 10], "--position-mm: give one"),
            (["--configuration", "short"], "does not know short in time; it knows long"),
            (["--every-ms", 0], "--every-ms 0: a positive number"),
            (["--every-ms", "nan"], "--every-ms nan: a positive number"),
            (["--every-ms", 1e-5], "rows and 500000 are the most"),
            (["--start", 2000], "the drive lasts from 0 to 1000 ms"),
            (["--run", 1], "is a table of one run"),
            (["--position-mm", 200], "long, at 200 mm: "),
        ],
        first=3,
    ),
)
def test_options_that_make_no_sense_are_refused(
    folder: Path, options: list[object], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert motion(folder, *options) == 2
    assert words in refused(capsys)
    assert not (folder / "motion.h5").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--run", 1, "--position-mm", 5], "--position-mm is what run 1 of the protocol says"),
        (["--run", 9], "has the runs 1 to 6"),
        (["--run", 3], "looks at the load cell without the sheet"),
    ],
)
def test_runs_that_make_no_sense_are_refused(
    folder: Path, options: list[object], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = PROTOCOL.replace('mode = "paper"', "no_touch_zero = true\nchirp = true\nrelease=true")
    (folder / "protocol.toml").write_text(text)
    assert motion(folder, *options, drive="protocol.toml") == 2
    assert words in refused(capsys)


@pytest.mark.parametrize(
    "options",
    [
        ["--drive", "drive.csv"],
        ["--run", 1],
        ["--every-ms", 2],
        ["--start", 5],
        ["-o", "motion.h5"],
        ["--force"],
    ],
)
def test_options_of_a_motion_are_refused_without_time(
    folder: Path, options: list[object], capsys: pytest.CaptureFixture[str]
) -> None:
    rest = ["--position-mm", 5, "--voltage", 0]
    assert labrig("simulate", folder / "model.toml", *rest, *options) == 2
    assert f"{options[0]} is of a motion; give --time with it." in refused(capsys)


def test_drive_and_file_are_needed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert motion(folder, drive="") == 2
    assert "--time needs --drive" in refused(capsys)
    assert motion(folder, file="") == 2
    assert "--time needs --drive" in refused(capsys)
    assert motion(folder, file="motion.txt") == 2
    assert "must end in .h5 (HDF5) or .csv" in refused(capsys)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time_s,voltage_V\n0,0\n0.5,2\n0.5,0\n", "line 4: time_s = 0.5 does not come after 0.5"),
        ("time_s,voltage_V\n0,0\n0.5,2\n0.4,0\n", "line 4: time_s = 0.4 does not come after 0.5"),
        ("time_s,voltage_V\n-1,0\n0.5,2\n", "line 2: time_s = -1: the sheet is at rest until"),
        ("time_s,voltage_V\n0,0\n0.5,31\n1,0\n", "voltage_V = 31 is beyond the ±30 V of any"),
        ("time_s,voltage_V\n0,0\n0.5,two\n1,0\n", "'two' is not a number"),
        ("time_s,voltage_V\n0,2\n", "has two rows at least"),
        ("time_s,volts\n0,2\n", "column 'volts' is not known"),
        ("", "this is an empty file"),
    ],
)
def test_a_table_that_is_no_drive_is_refused_at_its_line(
    folder: Path, text: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "drive.csv").write_text(text)
    assert motion(folder, "--position-mm", 5) == 2
    assert words in refused(capsys)
    assert not (folder / "motion.h5").exists()


def test_a_protocol_beyond_the_limit_of_any_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = PROTOCOL.replace("zero_readings", "voltages_V = [40.0, -2.0]\nzero_readings")
    (folder / "protocol.toml").write_text(text)
    assert motion(folder, drive="protocol.toml") == 2
    assert "30" in refused(capsys)


def test_a_sheet_that_leaves_the_rolls_is_told_with_the_time(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "drive.csv").write_text("time_s,voltage_V\n0.1,-12\n2,0\n")
    assert motion(folder, "--position-mm", 25) == 2
    assert "the sheet leaves the rolls at 0." in refused(capsys)
    assert list(folder.glob("motion*")) == []


def test_a_model_of_the_sheet_at_rest_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_model(model(dynamic=False), folder / "model.toml", force=True)
    assert motion(folder) == 2
    assert "knows the sheet at rest only" in refused(capsys)


def test_a_file_that_is_there_stays_unless_force_is_given(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "motion.csv").write_text("mine")
    assert motion(folder, file="motion.csv") == 2
    assert "--force" in refused(capsys)
    assert (folder / "motion.csv").read_text() == "mine"
    assert motion(folder, "--force", file="motion.csv") == 0
    assert (folder / "motion.csv").read_text().startswith("time_s,")


@pytest.mark.parametrize("ending", ["h5", "csv"])
def test_a_file_that_cannot_be_written_leaves_nothing(
    folder: Path, ending: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("labrig.session.recording.disk.sync_file", full)
    assert motion(folder, file=f"motion.{ending}") == 5
    assert "the disk is full" in refused(capsys)
    assert list(folder.glob("motion*")) == []


def test_a_folder_that_is_not_there_is_told(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert motion(folder, file="nowhere/motion.h5") == 2
    assert "cannot be written" in refused(capsys)
