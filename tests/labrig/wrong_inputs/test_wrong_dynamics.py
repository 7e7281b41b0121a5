"""Sheets in time, drives, controllers and references that cannot be: a sentence, no voltage."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.config.templates import write_templates
from labrig.model_file import save_model
from tests.end_to_end.faulty_rig import spied_writes
from tests.labrig.moving_model import model
from tests.labrig.simple_controller import MODEL_TEXT, write_control
from tests.labrig.wrong_inputs.files import refused

SIMULATE = "simulate model.toml --time --drive drive.csv --position-mm 5 -o motion.csv"
RESPONSE = "response model.toml --position-mm 5 -o response"
CONTROL = "control model.toml --position-mm 5 --method pi -o new.toml"
RUN = (
    "run rig.toml protocol.toml sheet.toml --yes -o s.h5"
    " --controller controller.toml --reference force.csv"
)
DYNAMIC = "[configurations.long.dynamic.{}]\nvalue = "
POSITIVE, NOT_NEGATIVE = "must be positive", "must be zero or positive"
# a quantity of the sheet in time -> its value, and what a value below 0 and 0 itself are told
QUANTITIES = {
    "mass_per_length_kg_per_m": ("0.005775", POSITIVE, POSITIVE),
    "electrode_ohm_per_m": ("4000.0", POSITIVE, POSITIVE),
    "capacitance_F_per_m": ("0.3", POSITIVE, POSITIVE),
    "bulk_ohm_m": ("0.5", POSITIVE, POSITIVE),
    "source_ohm": ("1.0", POSITIVE, POSITIVE),
    "elongation_mass_kg_per_m": ("0.004", POSITIVE, POSITIVE),
    "prony.share": ("0.15", POSITIVE, POSITIVE),
    "prony.time_s": ("0.02", POSITIVE, POSITIVE),
    "load_cell.resonance_hz": ("100.0", POSITIVE, POSITIVE),
    "viscous_time_s": ("0.0002", NOT_NEGATIVE, None),
    "leak_S_per_m": ("0.1", NOT_NEGATIVE, None),
    "load_cell.damping": ("0.02", NOT_NEGATIVE, None),
}
WRONG = [
    (name, value, bad, told)
    for name, (value, below, zero) in QUANTITIES.items()
    for bad, told in (("-1.0", below), ("0.0", zero), ("nan", "a finite number is wanted"))
    if told
]
DRIVES = {
    "time_s,voltage_V\n0.1,60\n0.7,0\n": "drive.csv, line 2: voltage_V = 60 is beyond the ±30 V",
    "time_s,voltage_V\n0.1,nan\n0.7,0\n": "drive.csv, line 2: column voltage_V: 'nan' is not a",
    "time_s,voltage_V\n0.7,1\n0.1,0\n": "line 3: time_s = 0.1 does not come after 0.7",
    "time_s,voltage_V\n-0.7,1\n0.1,0\n": "line 2: time_s = -0.7: the sheet is at rest until",
    "time_s,voltage_V\n0.1,1\n": "two rows at least",
    "": "drive.csv: this is an empty file",
}
# what is changed in a file: its name, an old text, a new one -> what a controlled run is told
RUNS = {
    ("model.toml", "", "# another fit\n"): "was made from another model.toml",
    ("rig.toml", "sample_rate_hz = 1000.0", "sample_rate_hz = 100.0"): "the rig samples at 100 Hz",
    ("sheet.toml", "free_length_mm = 50", "free_length_mm = 49"): "was made for another sheet",
    ("controller.toml", "\nrate_hz = 200.0", "\nrate_hz = 50.0"): "is sampled at 200 Hz",
    ("controller.toml", "\nrate_hz = 200.0", "\nrate_hz = -1.0"): "rate_hz = -1.0",
    ("controller.toml", "voltage_V = 2.0", "voltage_V = 40.0"): "[limits] voltage_V = 40.0",
    ("controller.toml", "C = [", "C = [9e9, "): "[law] C should have",
    ("protocol.toml", "positions_mm", "positions_mm = [20] #"): "does not measure long at 5 mm",
    ("force.csv", "0,0", "-1,0"): "line 2: time_s = -1: a reference begins at 0",
    ("force.csv", "0.5,0.5", "0.5,much"): "'much' is not a number",
}


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("good")
    write_templates(folder, simulated=True)
    save_model(model(load_cell=True), folder / "sheet_in_time.toml")
    (folder / "drive.csv").write_text("time_s,voltage_V\n0.1,2\n0.7,-2\n1.0,0\n")
    (folder / "model.toml").write_text(MODEL_TEXT)
    write_control(folder, rate_hz=200.0)
    return folder


@pytest.fixture
def here(good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "here"
    shutil.copytree(good, folder)
    monkeypatch.chdir(folder)
    return folder


def in_time(folder: Path, name: str, value: str, bad: str) -> None:
    """The model file with one quantity of the sheet in time changed."""
    text = (folder / "sheet_in_time.toml").read_text()
    old = DYNAMIC.format(name) + value
    assert old in text
    (folder / "model.toml").write_text(text.replace(old, DYNAMIC.format(name) + bad, 1))


@pytest.mark.parametrize(("name", "value", "bad", "told"), WRONG)
def test_a_sheet_in_time_that_cannot_be_is_refused_by_its_key(
    here: Path, capsys: pytest.CaptureFixture[str], name: str, value: str, bad: str, told: str
) -> None:
    in_time(here, name, value, bad)
    said = refused(SIMULATE, capsys)
    assert told in said
    assert name.rpartition(".")[2] in said


@pytest.mark.parametrize("command", [RESPONSE, CONTROL])
def test_every_command_refuses_such_a_sheet(
    here: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    in_time(here, "mass_per_length_kg_per_m", "0.005775", "-1.0")
    assert "mass_per_length_kg_per_m: must be positive, not -1" in refused(command, capsys)


@pytest.mark.parametrize("text", list(DRIVES))
def test_a_drive_that_cannot_be_is_refused_by_its_line(
    here: Path, capsys: pytest.CaptureFixture[str], text: str
) -> None:
    shutil.copy("sheet_in_time.toml", "model.toml")
    (here / "drive.csv").write_text(text)
    assert DRIVES[text] in refused(SIMULATE, capsys)


@pytest.mark.parametrize("change", list(RUNS), ids=lambda change: f"{change[0]} {change[2]}")
def test_a_controlled_run_that_cannot_be_is_refused_before_any_voltage(
    here: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    change: tuple[str, str, str],
) -> None:
    file, old, new = change
    text = (here / file).read_text()
    assert old in text
    (here / file).write_text(text.replace(old, new, 1) if old else text + new)
    writes = spied_writes(monkeypatch)
    assert RUNS[change] in refused(RUN, capsys)
    assert not any(writes)


def test_a_drive_beyond_the_rigs_limit_is_refused_before_any_voltage(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = (here / "rig.toml").read_text()
    (here / "rig.toml").write_text(rig.replace("sheet_voltage_V = 2.5", "sheet_voltage_V = 1.5"))
    writes = spied_writes(monkeypatch)
    said = refused("run rig.toml protocol.toml sheet.toml --yes -o s.h5", capsys)
    assert "2 V at the sheet is beyond the limit of ±1.5 V ([limits] sheet_voltage_V)" in said
    assert not any(writes)


def test_an_unstable_loop_is_refused_before_any_voltage(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    write_control(here, rate_hz=200.0)
    text = (here / "controller.toml").read_text()
    row = next(line for line in text.splitlines() if line.startswith("D = ["))
    (here / "controller.toml").write_text(text.replace(row, "D = [90000.0, -90000.0]", 1))
    writes = spied_writes(monkeypatch)
    assert "the loop of [law] and [plant] is unstable" in refused(RUN, capsys)
    assert not any(writes)


@pytest.mark.parametrize("left_out", ["--controller controller.toml", "--reference force.csv"])
def test_a_controller_and_its_reference_go_together(
    here: Path, capsys: pytest.CaptureFixture[str], left_out: str
) -> None:
    assert "go together; give both" in refused(RUN.replace(f" {left_out}", ""), capsys)


def test_what_is_no_session_in_time_is_refused(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "there is no such file" in refused("fit gone.h5 --dynamic", capsys)
    assert run(["fit", "model.toml", "--dynamic"]) == 2
