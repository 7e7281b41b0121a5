"""The rig of `init --camera aravis --board labjack`, against devices simulated at the wire."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

from labrig.experiment.rig.networked_rig import SERVED_BOARDS, served_rig
from labrig.session import open_session
from protocols.execution.events import Outcome, OutputState
from tests.drivers.fake_gige import PACKAGE, fake_camera, needs_fake_camera
from tests.end_to_end.small_rig import labrig

pytestmark = [
    pytest.mark.alone,
    pytest.mark.slow,
    needs_fake_camera,
    pytest.mark.system_package(PACKAGE),
    pytest.mark.skipif(sys.platform == "win32", reason="the simulated rig needs a pty"),
]
PROTOCOL = """
moisten = false
[pulse_train]
zero_readings = 1
readings_per_voltage = 1
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
mode = "paper"
"""


@pytest.mark.parametrize("trigger", ["free", pytest.param("software", marks=pytest.mark.thorough)])
def test_it_passes_check_and_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], trigger: str
) -> None:
    folder = tmp_path / "rig"
    assert labrig("init", folder, "--camera", "aravis", "--board", "labjack") == 0
    rig = folder / "rig.toml"
    (folder / "protocol.toml").write_text(PROTOCOL)
    options = ("--boards", "labjack")
    with (
        fake_camera(tmp_path),
        served_rig(tmp_path / "world.csv", "long", options) as addresses,
    ):
        address = addresses[SERVED_BOARDS.get("labjack", "labjack")]
        text = re.sub(r'address = "[^"]*"', f'address = "{address}"', rig.read_text())
        rig.write_text(text.replace("exposure_s", f'trigger = "{trigger}"\nexposure_s', 1))
        capsys.readouterr()
        assert labrig("devices", "--json") == 0
        sources = [each["name"] for each in json.loads(capsys.readouterr().out)["cameras"]]
        assert "aravis:Aravis-Fake-GV01" in sources
        assert labrig("check", rig) == 0
        said = " ".join(capsys.readouterr().out.split())
        assert "ok camera Aravis Fake GV01" in said
        assert "640 x 480 at 0, 0, Mono8, exposure 5 ms" in said
        files = [folder / name for name in ("rig.toml", "protocol.toml", "sheet.toml")]
        assert labrig("run", *files, "--yes", "-o", folder / "session.h5") == 0
    with open_session(folder / "session.h5") as session:
        assert (session.outcome, session.output_state) == (Outcome.COMPLETED, OutputState.SAFE)
        (run,) = session.runs
        assert run.readings["valid"].all()
        assert (run.counts.frames_incomplete, run.counts.frames_missed) == (0, 0)
        numbers = run.frame_column("device_number")
        assert (numbers > 0).all()
        (camera,) = (device for device in session.devices if device.part == "camera")
        assert (camera.identity.product, camera.identity.serial) == ("Fake", "GV01")
        assert camera.acquisition is not None
        assert camera.acquisition.trigger == trigger
        if trigger == "software":
            # when the command was sent: the fake camera itself is only so punctual
            assert abs(run.readings["frame_offset_s"]).max() < 0.02


def test_init_of_a_simulated_one_runs_too(tmp_path: Path) -> None:
    options = ("--camera", "aravis", "--board", "labjack", "--simulated")
    assert labrig("init", tmp_path / "rig", *options) == 0
    assert labrig("check", tmp_path / "rig" / "rig.toml") == 0
    assert labrig("init", tmp_path / "no", "--camera", "fiwi") == 2
    assert not (tmp_path / "no").exists()
