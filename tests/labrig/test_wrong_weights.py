"""Dead weights that cannot be what they are said to be: refused, and the calibration stays."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.config.templates import write_templates
from labrig.experiment.operator import ConsoleOperator
from sim_hardware.operator import SimulatedOperator

pytestmark = pytest.mark.slow
SENSITIVITY = "sensitivity_V_per_N = 0.15296"


@pytest.mark.parametrize(
    ("change", "weights_mN", "told"),
    [
        (None, (0, 20, 5000), "5000 mN is above the load cell's capacity of 98.07 mN"),
        (None, (0, 20, -5000), "-5000 mN is above the load cell's capacity"),
        (("capacity_mN = 98.07", "capacity_mN = 9807"), (0, 20, 5000), "with 5000 mN the force"),
        ((SENSITIVITY, "sensitivity_V_per_N = 2.3"), (0, 20, 50), "the last calibration 2.3 V/N"),
        ((SENSITIVITY, "sensitivity_V_per_N = -0.153"), (0, 20, 50), "check the weights"),
    ],
)
def test_a_wrong_weight_is_refused_in_one_sentence(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    change: tuple[str, str] | None,
    weights_mN: tuple[float, ...],
    told: str,
) -> None:
    write_templates(tmp_path, simulated=True)
    file = tmp_path / "load_cell.toml"
    if change is not None:
        assert change[0] in file.read_text()
        file.write_text(file.read_text().replace(*change))
    before = file.read_text()
    weights = [f"--weight-mN={load}" for load in weights_mN]
    assert run(["calibrate", "load-cell", str(tmp_path / "rig.toml"), *weights]) == 2
    faults = [line for line in capsys.readouterr().err.splitlines() if line.startswith("labrig:")]
    assert len(faults) == 1
    assert told in faults[0]
    assert file.read_text() == before
    assert not list(tmp_path.glob("load_cell.*.toml"))


def test_a_first_calibration_may_find_any_sensitivity(tmp_path: Path) -> None:
    write_templates(tmp_path, simulated=True)
    file = tmp_path / "load_cell.toml"
    text = file.read_text().replace(SENSITIVITY, "sensitivity_V_per_N = 1.0")
    lines = ["date = 1970-01-01" if x.startswith("date =") else x for x in text.splitlines()]
    file.write_text("\n".join(lines))
    weights = [f"--weight-mN={load}" for load in (0, 20, 50)]
    assert run(["calibrate", "load-cell", str(tmp_path / "rig.toml"), *weights]) == 0


def test_a_calibration_that_nobody_answers_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    write_templates(tmp_path, simulated=True)
    before = (tmp_path / "load_cell.toml").read_text()
    monkeypatch.setattr(sys, "stdin", io.StringIO(""))
    nobody = ConsoleOperator(lambda _text: None)
    monkeypatch.setattr(SimulatedOperator, "ask", lambda _self, prompt: nobody.ask(prompt))
    weights = [f"--weight-mN={load}" for load in (0, 20, 50)]
    assert run(["calibrate", "load-cell", str(tmp_path / "rig.toml"), *weights]) == 3
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith("labrig: Nobody is there to answer: standard input has ended.")
    assert said.endswith("is done already.")
    assert (tmp_path / "load_cell.toml").read_text() == before
