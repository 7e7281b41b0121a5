"""controller.toml and its reference: every fault is one sentence, and nothing is energised."""

from pathlib import Path

import pytest
import tomlkit

from labrig.config.templates import write_templates
from labrig.control.controller_file import load_controller, rig_checksum
from labrig.control.reference import parse_reference
from labrig.errors import BadInputError
from labrig.experiment.plan import ControlFiles, load_plan
from protocols.planning.schedule import ForceStep
from tests.labrig.simple_controller import MODEL_TEXT, REFERENCE, controller, write_control

FILES = ("rig.toml", "protocol.toml", "sheet.toml")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_templates(tmp_path, simulated=True)
    (tmp_path / "model.toml").write_text(MODEL_TEXT)
    write_control(tmp_path)
    return tmp_path


def plan(folder: Path):
    control = ControlFiles(folder / "controller.toml", folder / "force.csv")
    return load_plan(*(folder / name for name in FILES), control=control)


def change(folder: Path, **values: object) -> None:
    """Replace keys of controller.toml; TABLE__KEY is one in a table."""
    path = folder / "controller.toml"
    data = tomlkit.parse(path.read_text())
    for name, value in values.items():
        table, _, key = name.rpartition("__")
        (data[table] if table else data)[key] = value
    path.write_text(tomlkit.dumps(data))


def said(folder: Path) -> str:
    with pytest.raises(BadInputError) as caught:
        plan(folder)
    text = str(caught.value)
    assert text.count("\n") == 0
    assert text.endswith(".")
    return text


def test_a_controller_that_was_written_is_read_back(folder: Path) -> None:
    found = load_controller(folder / "controller.toml")
    assert found == controller(folder / "sheet.toml")
    law = found.feedback()
    assert (law.rate_hz, law.limit_V, law.saturated_s) == (100.0, 2.0, 0.5)
    assert (law.A.shape, law.B.shape, law.C.shape, law.D.shape) == ((1, 1), (1, 2), (1,), (2,))


def test_a_plan_has_the_reference_at_the_controllers_place_and_nothing_else(folder: Path) -> None:
    found = plan(folder)
    (run,) = found.schedule.runs
    assert (run.configuration, run.position_m) == ("long", pytest.approx(0.005))
    assert (run.readings, run.duration_s) == ((), 4.0)
    assert run.reference[1] == ForceStep(0.5, pytest.approx(0.5e-3))
    assert {"controller.toml", "reference.csv"} <= set(found.texts)


def test_a_place_that_the_protocol_does_not_measure_names_its_file(folder: Path) -> None:
    change(folder, position_mm=12.5)
    (folder / "protocol.toml").rename(folder / "pulses.toml")
    control = ControlFiles(folder / "controller.toml", folder / "force.csv")
    with pytest.raises(BadInputError) as caught:
        load_plan(folder / "rig.toml", folder / "pulses.toml", folder / "sheet.toml",
                  control=control)  # fmt: skip
    assert str(caught.value).startswith(f"{folder / 'pulses.toml'}: the protocol does not measure")


def test_a_model_file_that_has_changed_is_noticed(folder: Path) -> None:
    (folder / "model.toml").write_text(MODEL_TEXT + "# another fit\n")
    assert "was made from another model.toml than the one that lies beside it" in said(folder)


def test_a_model_file_that_is_elsewhere_is_not_asked_for(folder: Path) -> None:
    (folder / "model.toml").unlink()
    assert plan(folder).controller is not None


def test_another_sheet_is_noticed(folder: Path) -> None:
    change(folder, sheet__free_length_mm=49.0)
    assert "another sheet: free_length_mm = 49 there, 50 in sheet.toml" in said(folder)


def test_another_rig_is_noticed_where_one_was_named(folder: Path) -> None:
    there = plan(folder)
    mine = rig_checksum(there.rig, there.calibration)
    write_control(folder, rig={"sha256": mine})
    assert plan(folder).controller is not None
    rig = folder / "rig.toml"
    rig.write_text(rig.read_text().replace("gain = 10.0", "gain = 20.0", 1))
    assert "was made for another rig" in said(folder)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"plant__rate_hz": 50.0}, "rate_hz = 100, but its [plant] is sampled at 50 Hz"),
        ({"rate_hz": 50.0}, "rate_hz = 50, but its [plant] is sampled at 100 Hz"),
        ({"law__D": [9e4, -9e4]}, "the loop of [law] and [plant] is unstable"),
        ({"law__B": [[1.0]]}, "[law] B should have 1 rows of 2 numbers"),
        ({"law__A": [[1.0, 0.0]]}, "[law] A should have 1 rows of 1 numbers"),
        ({"law__anti_windup": [1.0, 2.0]}, "[law] anti_windup should have 1 rows of 1 numbers"),
        ({"plant__B": [1.0]}, "[plant] B should have 1 rows of 2 numbers"),
        ({"law__C": [float("nan")]}, "finite"),
        ({"law__D": [1.0]}, "[law] D should have 1 rows of 2 numbers"),
        ({"rate_hz": 0.0}, "rate_hz = 0.0: should be greater than or equal to 4"),
        ({"labrig_controller": 2}, "labrig_controller = 2"),
        ({"output": "tip"}, "output = 'tip'"),
        ({"limits__voltage_V": -1.0}, "[limits] voltage_V = -1.0"),
        ({"configuration": "wide"}, "configuration = 'wide' is no table of sheet.toml"),
        ({"model__sha256": "abc"}, "[model] sha256 = 'abc'"),
        ({"position_mm": 7.5}, "does not measure long at 7.5 mm, the place of the controller"),
        ({"colour": "red"}, "colour is not a known key"),
    ],
)
def test_a_fault_in_the_file_is_one_sentence(folder: Path, values, words: str) -> None:
    change(folder, **values)
    assert words in said(folder)


def test_a_rig_that_samples_too_slowly_is_refused(folder: Path) -> None:
    write_control(folder, rate_hz=200.0)
    rig = folder / "rig.toml"
    rig.write_text(rig.read_text().replace("sample_rate_hz = 1000.0", "sample_rate_hz = 100.0", 1))
    assert "runs at 200 Hz, but the rig samples at 100 Hz" in said(folder)


def test_a_meter_is_too_slow_for_a_controller(folder: Path) -> None:
    with (folder / "rig.toml").open("a") as file:
        file.write('[force_sensor]\nkind = "dpm3"\nport = "/dev/ttyUSB0"\n')
    assert 'a controller needs the load cell on the boards; [force_sensor] kind = "dpm3"' in said(
        folder
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "this is an empty file; a CSV table is needed"),
        ("time_s,force_mN\n", "two rows at least"),
        ("time_s,force_mN\n0,0\n", "two rows at least"),
        ("time_s,force_lb\n0,0\n1,0\n", "force_lb"),
        ("time_s,force_mN\n0,a\n1,0\n", "line 2: column force_mN: 'a' is not a number"),
        ("time_s,force_mN\n0,nan\n1,0\n", "line 2: column force_mN: 'nan' is not a number"),
        ("time_s,force_mN\n1,0\n2,0\n", "line 2: time_s = 1: a reference begins at 0"),
        ("time_s,force_mN\n0,0\n2,0\n2,1\n", "line 4: time_s = 2 does not come after 2"),
        ("time_s,force_mN\n0,0\n31,0\n", "31 s under voltage is longer than the limit of 30 s"),
    ],
)
def test_a_fault_in_the_reference_is_one_sentence(folder: Path, text: str, words: str) -> None:
    (folder / "force.csv").write_text(text)
    assert words in said(folder)


def test_the_last_row_of_a_reference_is_its_end() -> None:
    steps, end_s = parse_reference(REFERENCE, "force.csv")
    assert (len(steps), steps[-1].time_s, end_s) == (4, 3.0, 4.0)
