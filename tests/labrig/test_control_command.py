"""`labrig control` and `labrig response` on the long sheet's model, and what they refuse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from labrig.cli.main import run
from labrig.config.templates import write_templates
from labrig.control.controller_file import load_controller
from labrig.experiment.plan import ControlFiles, load_plan
from labrig.model_file import save_model
from tests.labrig.moving_model import model

pytestmark = pytest.mark.slow


@pytest.fixture
def path(tmp_path: Path) -> Path:
    save_model(model(), tmp_path / "model.toml")
    return tmp_path / "model.toml"


def labrig(*arguments: object) -> int:
    return run([str(argument) for argument in arguments])


@pytest.mark.parametrize(("method", "settled_s"), [("pi", 0.5), ("lqg", 0.3)])
def test_a_controller_is_designed_that_a_run_takes(
    path: Path, method: str, settled_s: float, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = path.parent
    file = folder / "controller.toml"
    options = ["--position-mm", 5, "--rate-hz", 200, "--delay-ms", 3, "--method", method]
    assert labrig("control", path, "--output", "force", *options, "-o", file) == 0
    assert "within 2 % after" in capsys.readouterr().out
    found = load_controller(file)
    assert found.prediction is not None
    assert found.prediction.sensitivity_peak <= 1.61
    assert found.prediction.settled_s <= settled_s
    write_templates(folder, simulated=True)
    (folder / "force.csv").write_text("time_s,force_mN\n0,0\n0.5,1\n2,0\n")
    files = [folder / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    plan = load_plan(*files, control=ControlFiles(file, folder / "force.csv"))
    assert plan.schedule.runs[0].position_m == pytest.approx(0.005)


def test_a_controller_for_one_rig_names_it(path: Path) -> None:
    folder = path.parent
    write_templates(folder, simulated=True)
    file = folder / "controller.toml"
    options = ["--position-mm", 5, "--method", "pi", "--rig", folder / "rig.toml", "-o", file]
    assert labrig("control", path, *options) == 0
    assert load_controller(file).rig is not None


def test_a_limit_beyond_that_of_the_rig_is_refused(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_templates(path.parent, simulated=True)
    rig = path.parent / "rig.toml"
    options = ["--position-mm", 5, "--limit-V", 10, "--rig", rig, "-o", path.parent / "c.toml"]
    assert labrig("control", path, *options) == 2
    assert f"--limit-V 10: {rig} allows 2" in capsys.readouterr().err
    assert not (path.parent / "c.toml").exists()


@pytest.mark.thorough
@pytest.mark.parametrize("output", ["force", "tip", "current"])
def test_a_response_is_a_figure_and_two_tables(
    path: Path, output: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = path.parent / "answers"
    place = ["--position-mm", 5] if output == "force" else []
    options = ["--input", "voltage", "--output", output, *place, "-o", folder, "--format", "svg"]
    assert labrig("response", path, *options) == 0
    assert "gain at rest" in capsys.readouterr().out
    names = {file.name for file in folder.iterdir()}
    assert names == {f"{output}.svg", f"{output}_step.csv", f"{output}_bode.csv"}
    step = np.genfromtxt(folder / f"{output}_step.csv", delimiter=",", names=True)
    bode = np.genfromtxt(folder / f"{output}_bode.csv", delimiter=",", names=True)
    column = next(name for name in bode.dtype.names if name.endswith("_per_V"))
    # at 0.01 Hz it is nearly at rest; after 3 s the step is nearly there
    assert step[column][-1] == pytest.approx(bode[column][0], rel=0.15)
    assert bode["frequency_hz"][0] == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["response"], "give --position-mm for the force"),
        (["response", "--output", "tip", "--configuration", "short"], "does not know short"),
        (["response", "--position-mm", 90], "cannot be reached"),
        (["control", "--position-mm", 5, "--rate-hz", 0], "--rate-hz 0: a number from 4 to 2000"),
        (["control", "--position-mm", 5, "--rate-hz", 3], "--rate-hz 3: a number from 4 to 2000"),
        (["control", "--position-mm", 5, "--delay-ms", -1], "--delay-ms -1: a number from 0 to"),
        (["control", "--position-mm", 5, "--limit-V", 100], "--limit-V 100: a positive voltage"),
        (["control", "--position-mm", 90], "cannot be reached"),
        (["response", "--position-mm", 5, "-o", "bode.csv"], "-o is a folder: bode.csv"),
    ],
)
def test_what_cannot_be_answered_is_one_sentence(
    path: Path, arguments: list[object], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert labrig(arguments[0], path, *arguments[1:]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "Traceback" not in said
    assert not list(path.parent.glob("controller.toml"))


def test_a_model_of_the_sheet_at_rest_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_model(model(dynamic=False), tmp_path / "still.toml")
    assert labrig("control", tmp_path / "still.toml", "--position-mm", 5) == 2
    assert "knows the sheet at rest only" in capsys.readouterr().err
