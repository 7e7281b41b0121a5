"""`labrig init` for parts that bring no text to start from: their settings are the text."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.config import PROTOCOLS, load_rig
from labrig.config.templates.settings_text import settings_text
from labrig.session.tables.drive_table import load_protocol


@dataclass(frozen=True, kw_only=True)
class Settings:
    port: str = field(metadata={"description": "serial port"})
    range_mm: float = field(default=60.0, metadata={"unit": "mm", "description": "its travel"})
    homes: bool = False
    gain: float | None = field(default=None, metadata={"description": "as it is set"})
    axes: tuple[str, ...] = ("x", "y")


PARTS = """
from dataclasses import dataclass, field
from drivers.boards.contract import BoardFamily
from drivers.boards.ni.family import BOARDS as NI
from drivers.cameras.contract import CameraKind, CameraSettings

@dataclass(frozen=True, kw_only=True)
class Card:
    address: str = "card0"
    sample_rate_hz: float = 1000.0

@dataclass(frozen=True, kw_only=True)
class Folder(CameraSettings):
    loop: bool = field(default=True, metadata={"description": "begin again after the last"})

def make(settings, clock, rate_hz): ...

CAMERA = CameraKind(kind="folder", help="images", settings=Folder, make=make, prefix="folder:",
                    sets=frozenset({"gain"}))
BOARDS = BoardFamily(kind="card", help="boards", settings=Card, connect=NI.connect,
                     inputs=lambda _: NI.inputs(NI.settings()), output_place=NI.output_place,
                     rescue=NI.rescue)
"""


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    info = tmp_path / "site" / "starters-1.0.dist-info"
    info.mkdir(parents=True)
    (tmp_path / "site" / "starters.py").write_text(PARTS)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: starters\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[labrig.cameras]\nfolder = starters:CAMERA\n[labrig.boards]\ncard = starters:BOARDS\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    monkeypatch.delitem(sys.modules, "starters", raising=False)
    return tmp_path


def test_settings_are_written_with_their_defaults_and_what_they_are() -> None:
    assert [" ".join(line.split()) for line in settings_text(Settings).splitlines()] == [
        "# port = # needed: serial port",
        "range_mm = 60.0 # its travel, in mm",
        "homes = false",
        "# gain = # as it is set",
        'axes = ["x", "y"]',
    ]


def test_boards_and_a_camera_that_bring_no_text_are_written_from_their_settings(
    installed: Path,
) -> None:
    folder = installed / "rig"
    assert run(["init", str(folder), "--board", "card", "--camera", "folder"]) == 0
    rig = load_rig(folder / "rig.toml")
    assert (rig.boards_kind, rig.boards.address) == ("card", "card0")
    assert rig.camera is not None
    assert (rig.camera.kind, rig.camera.source) == ("folder", "folder:")
    assert "# gain =" in (folder / "rig.toml").read_text()
    assert "exposure_s" not in (folder / "rig.toml").read_text()


def test_boards_that_bring_no_simulated_rig_are_refused_with_what_to_do(
    installed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["init", str(installed / "rig"), "--simulated", "--board", "card"]) == 2
    assert "these boards bring no simulated rig to start from; leave out" in capsys.readouterr().err


def test_a_simulated_rig_may_have_any_stage_and_meter_that_are_simulated(tmp_path: Path) -> None:
    options = ["--simulated", "--stage", "zaber", "--force-sensor", "dpm3"]
    assert run(["init", str(tmp_path / "rig"), *options]) == 0
    rig = load_rig(tmp_path / "rig" / "rig.toml")
    assert (rig.stage.kind, rig.stage.port) == ("zaber", "simulated")
    assert (rig.force_sensor.kind, rig.force_sensor.port) == ("dpm3", "simulated")


@pytest.mark.parametrize("kind", sorted(PROTOCOLS.parts()))
def test_any_kind_of_protocol_is_written_from_its_fields_and_read_again(
    tmp_path: Path, kind: str
) -> None:
    assert run(["init", str(tmp_path / "rig"), "--simulated", "--protocol", kind]) == 0
    path = tmp_path / "rig" / "protocol.toml"
    text = path.read_text(encoding="utf-8")
    assert text.count("[pulse_train]") == (kind == "pulse_train")
    made = load_protocol(path)
    assert made.protocol() == PROTOCOLS.get(kind)()
    assert len(made.schedule("protocol.toml").runs) == 14


def test_keys_of_a_protocol_have_their_units_and_meanings_as_comments(tmp_path: Path) -> None:
    run(["init", str(tmp_path / "rig"), "--protocol", "staircase"])
    lines = (tmp_path / "rig" / "protocol.toml").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("# What is done at each position. A sweep over voltages, each held")
    assert any(line.endswith("] # of the stairs, in their order, in V") for line in lines)
    assert "dwell_s = 1.0                      # on each stair, in s" in lines


def test_an_unknown_kind_of_protocol_is_answered_with_those_there_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["init", str(tmp_path / "rig"), "--protocol", "stairs"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "--protocol stairs: there is no protocol 'stairs'; choose one of: " in said
    assert not (tmp_path / "rig").exists()


def test_an_unknown_stage_is_answered_with_those_there_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["init", str(tmp_path / "rig"), "--stage", "zabr"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "--stage zabr: there is no positioner 'zabr'; choose one of: " in said
