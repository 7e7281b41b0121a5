"""Camera, stage, meter and boards of another distribution: checked, run, made safe, recorded."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from labrig.session import open_session
from labrig.session.reading.guard_report import guard_report_path
from protocols.execution.events import Outcome, OutputState
from tests.end_to_end.real_rig import ServedRig, serving
from tests.end_to_end.small_rig import make_rig

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="the simulated stage needs a pty"),
]

# What they reach is the served rig; what matters is that labrig knows them by their names alone.
CODE = '''
import threading
from dataclasses import dataclass, field

from drivers.boards.contract import BoardFamily
from drivers.boards.ni.family import BOARDS as NI
from drivers.cameras.contract import CameraKind, CameraSettings
from drivers.cameras.opencv import CAMERA as OPENCV
from drivers.force_sensors.contract import ForceSensorKind
from drivers.force_sensors.dpm3 import FORCE_SENSOR as DPM3
from drivers.positioners.contract import PositionerKind
from drivers.positioners.zaber import POSITIONER as ZABER


@dataclass(frozen=True, kw_only=True)
class FireflySettings(CameraSettings):
    """A camera with a gain."""

    gain_dB: float = field(default=0.0, metadata={"ge": 0, "le": 24, "description": "of the chip"})


def open_firefly(settings, clock, rate_hz):
    source = settings.source.removeprefix("firefly:")
    return OPENCV.make(CameraSettings(source=source), clock, rate_hz)


FIREFLY = CameraKind(kind="firefly", help="a camera", settings=FireflySettings,
                     make=open_firefly, prefix="firefly:")

def open_stuck(settings, clock, rate_hz):
    camera = open_firefly(settings, clock, rate_hz)
    camera.close = lambda: threading.Event().wait(300)
    return camera


STUCK = CameraKind(kind="stuck", help="a camera that does not close", make=open_stuck)

ROBOT = PositionerKind(kind="robot", help="a robot", settings=ZABER.settings, make=ZABER.make)
SCALE = ForceSensorKind(kind="scale", help="a scale", settings=DPM3.settings, make=DPM3.make)


@dataclass(frozen=True, kw_only=True)
class PicoSettings:
    """Boards of our own."""

    address: str = field(metadata={"description": "host:port"})
    sample_rate_hz: float = field(default=1000.0, metadata={"gt": 0, "description": "of each"})


def ni(settings):
    return NI.settings(address=settings.address, sample_rate_hz=settings.sample_rate_hz)


PICO = BoardFamily(
    kind="pico",
    help="boards of our own",
    settings=PicoSettings,
    connect=lambda settings, clock, transport: NI.connect(ni(settings), clock, transport),
    inputs=lambda settings: NI.inputs(ni(settings)),
    output_place=lambda settings, *limits: NI.output_place(ni(settings), *limits),
    rescue=NI.rescue,
)
UNSAFE = BoardFamily(
    kind="unsafe",
    help="boards that nobody can make safe",
    settings=PicoSettings,
    connect=PICO.connect,
    inputs=PICO.inputs,
    output_place=PICO.output_place,
)
'''
POINTS = """
[labrig.cameras]
firefly = lab_devices:FIREFLY
stuck = lab_devices:STUCK
[labrig.positioners]
robot = lab_devices:ROBOT
[labrig.force_sensors]
scale = lab_devices:SCALE
[labrig.boards]
pico = lab_devices:PICO
unsafe = lab_devices:UNSAFE
"""
METADATA = "Metadata-Version: 2.1\nName: lab-devices\nVersion: 3.1\n"


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A distribution in a folder of its own, which the processes that are started find."""
    site = tmp_path / "site"
    info = site / "lab_devices-3.1.dist-info"
    info.mkdir(parents=True)
    (site / "lab_devices.py").write_text(CODE)
    (info / "METADATA").write_text(METADATA)
    (info / "entry_points.txt").write_text(POINTS)
    path = os.pathsep.join([str(site), str(Path(__file__).parents[2])])
    monkeypatch.setenv("PYTHONPATH", path)
    return site


@pytest.fixture
def rig(installed: Path, tmp_path: Path) -> Iterator[ServedRig]:
    del installed
    with serving(tmp_path) as rig:
        file = rig.folder / "rig" / "rig.toml"
        head, _, rest = file.read_text().partition("[ni]")
        rest = rest[rest.index("[amplifier]") :]
        rest = rest.replace('source = "', 'gain_dB = 3\nsource = "firefly:')
        rest = rest.replace('"zaber"', '"robot"')
        pico = f'[pico]\naddress = "{rig.addresses["grpc"]}"\n'
        scale = f'[force_sensor]\nkind = "scale"\nport = "{rig.addresses["meter"]}"\n'
        file.write_text(head + pico + rest + scale)
        yield rig
        rig.end()


def command(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run labrig as a process of its own."""
    line = [sys.executable, "-m", "labrig", *map(str, arguments)]
    return subprocess.run(line, capture_output=True, text=True, timeout=120, check=False)


def test_parts_of_another_distribution_work_like_our_own(rig: ServedRig) -> None:
    file = rig.folder / "rig" / "rig.toml"
    checked = command("check", file)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    rig.be_short()
    assert rig.start().wait(90) == 0, rig.said()
    with open_session(rig.session) as session:
        assert session.outcome is Outcome.COMPLETED
        assert session.output_state is OutputState.SAFE
        found = session.resolved["rig"]
        assert found["pico"]["address"] == rig.addresses["grpc"]
        assert found["camera"]["kind"] == "firefly"
        assert found["camera"]["gain_dB"] == 3
        assert (found["stage"]["kind"], found["force_sensor"]["kind"]) == ("robot", "scale")
        assert session.versions["lab-devices"] == "3.1"
        parts = ("boards.pico", "cameras.firefly", "force_sensors.scale", "positioners.robot")
        assert {name: session.versions[name] for name in parts} == dict.fromkeys(
            parts, "lab-devices 3.1"
        )
    safe = command("safe", file)
    assert safe.returncode == 0, safe.stdout + safe.stderr
    assert "the output is safe: 0 V written" in safe.stdout + safe.stderr


def test_a_camera_that_never_closes_keeps_neither_the_program_nor_the_boards(
    rig: ServedRig,
) -> None:
    file = rig.folder / "rig" / "rig.toml"
    text = file.read_text().replace("gain_dB = 3\n", 'kind = "stuck"\n')
    file.write_text(text)
    rig.be_short()
    for _ in range(2):  # the boards are free for the second
        assert rig.start().wait(90) == 0, rig.said()
        assert "warning: closing the camera has not come to an end in 8 s." in rig.said()
        assert "the output is at 0 V, read back" in rig.said()


def test_the_guard_makes_their_boards_safe_when_labrig_is_killed(rig: ServedRig) -> None:
    process = rig.energised()
    process.kill()
    rig.until(lambda: guard_report_path(rig.session).exists(), timeout_s=20.0)
    assert json.loads(guard_report_path(rig.session).read_text())["state"] == "safe"
    assert abs(rig.drive_V()) < 0.05


@pytest.fixture
def unserved(installed: Path, tmp_path: Path) -> Path:
    """The rig.toml of one that is looked at no further than its own words."""
    del installed
    file = make_rig(tmp_path / "rig") / "rig.toml"
    head, _, rest = file.read_text().partition("[ni]")
    rest = rest[rest.index("[amplifier]") :].replace('source = "simulated"', 'source = "firefly:"')
    rest = rest.partition("[simulated]")[0]
    file.write_text(f'{head}[pico]\naddress = "127.0.0.1:9"\n{rest}')
    return file


@pytest.mark.thorough
def test_boards_that_cannot_make_themselves_safe_are_refused(unserved: Path) -> None:
    file = unserved
    file.write_text(file.read_text().replace("[pico]", "[unsafe]"))
    for name in ("check", "safe"):
        done = command(name, file)
        assert done.returncode != 0
        assert "[unsafe] cannot be made safe by another process" in done.stdout + done.stderr


@pytest.mark.thorough
def test_a_rig_has_one_family_of_boards(unserved: Path) -> None:
    unserved.write_text(unserved.read_text() + "[ni]\n")
    done = command("check", unserved)
    assert done.returncode == 2
    assert "[ni] and [pico]; a rig has one table of boards" in done.stderr


@pytest.mark.thorough
def test_the_schema_shows_the_keys_of_every_part(installed: Path, tmp_path: Path) -> None:
    del installed
    assert command("config", "schema", tmp_path).returncode == 0
    text = (tmp_path / "rig.schema.json").read_text()
    assert all(f'"{word}"' in text for word in ("gain_dB", "robot", "scale", "pico"))


def test_a_file_in_each_folder_is_a_part(tmp_path: Path) -> None:
    """The drivers are copied, one file is put into each folder, and no other line is changed."""
    import shutil

    root = Path(__file__).parents[2]
    shutil.copytree(root / "drivers", tmp_path / "drivers")
    for folder, constant, part in (
        ("cameras", "CAMERA", "FIREFLY"),
        ("positioners", "POSITIONER", "ROBOT"),
        ("force_sensors", "FORCE_SENSOR", "SCALE"),
        ("boards", "BOARDS", "PICO"),
    ):
        name = part.lower()
        file = tmp_path / "drivers" / folder / f"{name}.py"
        file.write_text(f"{CODE}\n{constant} = {part}\n")
    rig = tmp_path / "rig.toml"
    rig.write_text(
        '[pico]\naddress = "here:1"\n[load_cell]\ncalibration = "c.toml"\n'
        '[camera]\nsource = "firefly:1"\noptics = "o.json"\n'
        '[stage]\nkind = "robot"\nport = "COM1"\n[force_sensor]\nkind = "scale"\nport = "COM2"\n'
    )
    script = (
        "import sys; from pathlib import Path; from labrig.config import load_rig\n"
        "rig = load_rig(Path(sys.argv[1]))\n"
        "print(rig.boards_kind, rig.camera.kind, rig.stage.kind, rig.force_sensor.kind)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(rig)],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(root)])},
    )
    assert done.stdout.split() == ["pico", "firefly", "robot", "scale"], done.stderr
