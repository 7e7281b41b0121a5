"""A device that dies between opening and its checks fails a row; the other rows are kept."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from drivers.cameras.capture_camera import CaptureCamera
from drivers.interfaces import DeviceError
from drivers.positioners.manual import ManualStage
from labrig.cli.main import run
from labrig.config.templates import write_templates

pytestmark = pytest.mark.slow


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    write_templates(tmp_path, simulated=True)
    return tmp_path / "rig.toml"


def dies_by(monkeypatch: pytest.MonkeyPatch, device: type, method: str, fault: Exception) -> None:
    def die(*_: object) -> None:
        raise fault

    monkeypatch.setattr(device, method, die, raising=False)


def test_a_camera_that_dies_fails_its_row_of_the_table(
    rig: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    dies_by(monkeypatch, CaptureCamera, "start", DeviceError("camera 0: it hung up."))
    assert run(["check", str(rig)]) == 3
    shown = capsys.readouterr()
    assert "output at 0 V" in shown.out
    assert "FAILED" in shown.out
    told = " ".join(shown.err.split())
    assert "is not ready: camera: camera 0: it hung up, wanted an answer." in told
    files = [str(rig.parent / name) for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    assert run(["run", *files, "-o", str(rig.parent / "s.h5"), "--yes"]) == 3
    assert "The rig is not ready: camera: camera 0: it hung up" in capsys.readouterr().err


def test_a_stage_that_fails_as_no_driver_may_fails_its_row_and_the_camera_is_checked(
    rig: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    dies_by(monkeypatch, ManualStage, "travel_m", RuntimeError("no answer"))
    assert run(["check", str(rig), "--json"]) == 3
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["checks"]}
    assert rows["stage"]["found"] == "checking the stage failed: RuntimeError: no answer"
    assert rows["camera rate"]["ok"]
