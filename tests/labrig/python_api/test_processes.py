"""How many processes analyse a session: one in a script, which need not be importable."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import pytest

import labrig
from labrig.cli.main import run
from labrig.errors import LabrigError
from tests.labrig.session.session_recording import record, small_schedule

FUNCTIONS: dict[str, Callable[[Path], object]] = {
    "fit": labrig.fit,
    "fit of several": lambda path: labrig.fit([path]),
    "diagnose": labrig.diagnose,
    "compare": lambda path: labrig.compare(path, static=True),
    "next": labrig.next_measurement,
    "plot": labrig.plot.forces,
}


@pytest.fixture
def session(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A session that is not analysed; whoever does it is told by how many processes."""

    def analyze(*_: object, workers: int, **__: object) -> None:
        raise LabrigError(f"analysed by {workers}.")

    monkeypatch.setattr(import_module("labrig.analysis.analyze"), "analyze", analyze)
    monkeypatch.setattr("labrig.report.data.findings.workers", lambda: 3)
    path = tmp_path / "s.h5"
    record(path, small_schedule(readings=1, positions_m=(0.005,)))
    return path


@pytest.mark.slow
@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.filterwarnings("ignore:.*not analysed yet:labrig.LabrigWarning")
def test_a_function_analyses_by_one_process(session: Path, name: str) -> None:
    """Others would begin a script anew that is not under `if __name__ == "__main__":`."""
    with pytest.raises(LabrigError, match="analysed by 1"):
        FUNCTIONS[name](session)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["fit", "diagnose", "compare", "next", "report"])
def test_a_command_analyses_by_several(
    session: Path, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([command, str(session)]) != 0
    assert "analysed by 3." in capsys.readouterr().err
